#include <cstddef>

#include "touchstone/adapters/python/arrays.hpp"
#include "touchstone/adapters/python/world.hpp"

namespace touchstone::python {
namespace {

std::array<double, 3> array3(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

EventRow row_of(const ContactEvent& event) {
  const PairGeometry& at = event.geometry;
  return {number_of(event.a),
          number_of(event.b),
          event.solids.a,
          event.solids.b,
          event.part,
          event.kind,
          {},
          event.s,
          at.separation,
          array3(at.n_AB_W),
          array3(at.p_A_W),
          array3(at.p_B_W),
          event.geometry_at_end.separation};
}

const py::dtype& event_dtype() {
  static const auto* const dtype =
      new py::dtype(record_dtype({{"kind", "u1", offsetof(EventRow, kind)},
                                  {"a", "u8", offsetof(EventRow, a)},
                                  {"b", "u8", offsetof(EventRow, b)},
                                  {"solid_a", "u4", offsetof(EventRow, solid_a)},
                                  {"solid_b", "u4", offsetof(EventRow, solid_b)},
                                  {"part", "u4", offsetof(EventRow, part)},
                                  {"s", "f8", offsetof(EventRow, s)},
                                  {"separation", "f8", offsetof(EventRow, separation)},
                                  {"n_AB_W", "(3,)f8", offsetof(EventRow, n_AB_W)},
                                  {"p_A_W", "(3,)f8", offsetof(EventRow, p_A_W)},
                                  {"p_B_W", "(3,)f8", offsetof(EventRow, p_B_W)},
                                  {"separation_at_end", "f8", offsetof(EventRow, separation_at_end)}},
                                 sizeof(EventRow)));
  return *dtype;
}

FeelRow row_of(const HandFeel& felt) {
  return {number_of(felt.object),  array3(felt.p_W),     array3(felt.lag_W),
          array3(felt.turn_lag_W), array3(felt.force_W), array3(felt.moment_W)};
}

const py::dtype& feel_dtype() {
  static const auto* const dtype =
      new py::dtype(record_dtype({{"object", "u8", offsetof(FeelRow, object)},
                                  {"p_W", "(3,)f8", offsetof(FeelRow, p_W)},
                                  {"lag_W", "(3,)f8", offsetof(FeelRow, lag_W)},
                                  {"turn_lag_W", "(3,)f8", offsetof(FeelRow, turn_lag_W)},
                                  {"force_W", "(3,)f8", offsetof(FeelRow, force_W)},
                                  {"moment_W", "(3,)f8", offsetof(FeelRow, moment_W)}},
                                 sizeof(FeelRow)));
  return *dtype;
}

/// A member of a report as an array that holds on to it.
template <class Row>
py::array rows_of(const py::object& self, const py::dtype& dtype, std::vector<Row> Report::*member) {
  const std::vector<Row>& rows = self.cast<const Report&>().*member;
  return view(dtype, {static_cast<py::ssize_t>(rows.size())}, rows.data(), self, true);
}

}  // namespace

Report kept(const FrameReport& of) {
  Report made{of.frame,
              of.queries,
              of.slide_pairs,
              of.most_slide_work,
              of.blocked_movers,
              of.candidate_pairs,
              of.iteration_limits,
              of.slide_steps,
              static_cast<std::uint32_t>(of.refused_selections.size()),
              of.check == MotionCheck::proven,
              {},
              {},
              {}};
  made.events.reserve(of.events.size());
  for (const ContactEvent& event : of.events) made.events.push_back(row_of(event));
  for (const HandFeel& felt : of.felt) made.felt.push_back(row_of(felt));
  for (const ObjectHandle object : of.cut_off) made.cut_off.push_back(number_of(object));
  return made;
}

void bind_report(py::module_& module) {
  py::class_<Report>(module, "FrameReport", "How a frame went; counts are of this frame.")
      // Lists: events, what hands felt, who was cut off.
      .def_property_readonly(
          "events", [](const py::object& self) { return rows_of(self, event_dtype(), &Report::events); },
          "(k,) records: kind (touchstone.EventKind), a and b (int(object)), solid_a, solid_b, part, s, "
          "separation [m], n_AB_W, p_A_W, p_B_W (3,), separation_at_end [m].")
      .def_property_readonly(
          "felt", [](const py::object& self) { return rows_of(self, feel_dtype(), &Report::felt); },
          "(k,) records, one a hand whose mover slid, at the frame's end: object (int(object); of a "
          "mechanism its first link), p_W (3,) of the tool frame's origin [m], lag_W (3,) from there to "
          "where the command has it [m], turn_lag_W (3,) axis times angle [rad], force_W (3,) of the "
          "contacts on the mover [N], moment_W (3,) about p_W [N m].")
      .def_property_readonly(
          "cut_off_movers",
          [](const py::object& self) {
            return rows_of(self, py::dtype::of<std::uint64_t>(), &Report::cut_off);
          },
          "(k,) uint64, int(object): movers whose slides the budget ended; of a mechanism its first link.")
      .def_property_readonly(
          "cut_off", [](const Report& self) { return self.cut_off.size(); }, "How many of these there are.")
      // Counts.
      .def_readonly("frame", &Report::frame, "The frame's number.")
      .def_readonly("blocked_movers", &Report::blocked_movers,
                    "Movers stopped on their commanded paths, and loads that go along.")
      .def_readonly("candidate_pairs", &Report::candidate_pairs,
                    "Pairs looked at; all others stay out of reach.")
      .def_readonly("queries", &Report::queries, "Calls of the narrowphase.")
      .def_readonly("iteration_limits", &Report::iteration_limits,
                    "Pairs stopped early for want of iterations.")
      .def_readonly("slide_steps", &Report::slide_steps, "Sub-steps of slides.")
      .def_readonly("slide_pairs", &Report::slide_pairs, "As World.set_slide_budget() counts them.")
      .def_readonly("most_slide_work", &Report::most_slide_work,
                    "The most that one mover's slide took, as World.set_slide_budget() counts mover_work.")
      .def_readonly("refused_selections", &Report::refused_selections,
                    "Changes of the selection that named what is gone: without effect.")
      .def_readonly("is_proven", &Report::is_proven, "False: checked at sampled poses only.");
}

}  // namespace touchstone::python
