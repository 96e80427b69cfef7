#include "touchstone/tests/world/set_up/edited_worlds.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <ostream>
#include <set>
#include <tuple>
#include <utility>

#include "touchstone/tests/support/random_solid.hpp"
#include "touchstone/tests/world/arms/arm_fixture.hpp"
#include "touchstone/tests/world/levels_fixture.hpp"

namespace touchstone {
namespace {

constexpr int kBars = 3, kFrames = 12;

/// A registration or a change, by names. One that is shared by all flights.
struct Edit {
  enum class Kind {
    add,
    add_arm,
    remove,
    remove_arm,
    latch,
    unlatch,
    exempt,
    unexempt,
    switch_on,
    switch_off,
    rule
  };
  Kind kind;
  std::string a, b = {};
  std::shared_ptr<const HexahedronTree> tree = {};
  Pose X_WO = {};
  bool is_static = false;
  bool in_group = false;
  PairRule rule = {};
};

struct ObjectCommand {
  std::string name;
  RigidPath path;
};
struct ArmCommand {
  std::string arm;
  std::vector<double> values;
};

PairRule draw_rule(Random& random) {
  constexpr std::array kPolicies{ContactPolicy::slide,   ContactPolicy::slide, ContactPolicy::slide,
                                 ContactPolicy::advance, ContactPolicy::hold,  ContactPolicy::cue};
  constexpr std::array kPassive{Passive::stays, Passive::shoved, Passive::carried};
  PairRule out = rule(kPolicies[random.below(6)]);
  if (random.one_in(3)) out.passive = kPassive[random.below(3)];
  if (random.one_in(4)) out.warn_distance = random.uniform(0.0, 0.2);
  return out;
}

/// One of the same worlds.
class Flight {
 public:
  Flight() : world_(make_world()) { world_->set_default_hand(HandStiffness{}); }
  /// From now on objects that come have levels.
  void use_levels() { has_levels_ = true; }

  ContactWorld& world() { return *world_; }
  const ContactWorld& world() const { return *world_; }
  ObjectHandle object(const std::string& name) const { return objects_.at(name); }
  MechanismHandle arm(const std::string& name) const { return arms_.at(name); }

  void apply(const Edit& edit) {
    using Kind = Edit::Kind;
    switch (edit.kind) {
      // Objects and arms come and go.
      case Kind::add:
        keep(edit.a,
             world_->add({edit.tree, edit.X_WO, edit.is_static,
                          edit.in_group ? std::vector<std::string>{"some"} : std::vector<std::string>{},
                          has_levels_ ? levels_about(*edit.tree, 2) : Levels{}}));
        return;
      case Kind::add_arm: {
        const MechanismHandle arm = world_->add_mechanism({make_arm(edit.a, kBars), edit.X_WO, {}});
        arms_[edit.a] = arm;
        if (edit.in_group) world_->set_hand(arm, ArmHandStiffness{"tip"});
        for (int k = 1; k <= kBars; ++k)
          keep(edit.a + "." + std::to_string(k), world_->link(arm, std::to_string(k)));
        return;
      }
      case Kind::remove:
        world_->remove(object(edit.a));
        return;
      case Kind::remove_arm:
        world_->remove_mechanism(arm(edit.a));
        return;
      // Latches and exemptions.
      case Kind::latch:
        world_->latch(object(edit.a), object(edit.b));
        return;
      case Kind::unlatch:
        world_->unlatch(object(edit.a));
        return;
      case Kind::exempt:
        world_->exempt({object(edit.a), object(edit.b)});
        return;
      case Kind::unexempt:
        world_->unexempt({object(edit.a), object(edit.b)});
        return;
      // Switches and rules.
      case Kind::switch_on:
        world_->select(SelectionChange::of(object(edit.a), true));
        return;
      case Kind::switch_off:
        world_->select(SelectionChange::of(object(edit.a), false));
        return;
      case Kind::rule:
        set_rule(edit);
        return;
    }
  }

  FrameReport fly(std::span<const ObjectCommand> object_commands, std::span<const ArmCommand> arm_commands) {
    std::vector<MotionCommand> commands;
    for (const ObjectCommand& each : object_commands) commands.push_back({object(each.name), each.path});
    std::vector<JointCommand> joints;
    for (const ArmCommand& each : arm_commands) joints.push_back({arm(each.arm), each.values});
    return world_->frame(commands, joints);
  }

  /// By values and names alone, sorted.
  std::vector<std::string> events_of(const FrameReport& report) const {
    std::vector<std::string> out;
    for (const ContactEvent& event : report.events) {
      std::string a = name_of(event.a), b = name_of(event.b);
      if (b < a) std::swap(a, b);
      std::array<char, 200> text;
      std::snprintf(text.data(), text.size(), "%d %u %a %a %a ", static_cast<int>(event.kind), event.part,
                    event.s, event.geometry.separation, event.geometry_at_end.separation);
      out.push_back(text.data() + a + " " + b);
    }
    std::sort(out.begin(), out.end());
    return out;
  }

 private:
  void keep(const std::string& name, ObjectHandle object) {
    objects_[name] = object;
    names_[{object.slot, object.generation}] = name;
  }
  std::string name_of(ObjectHandle object) const {
    const auto found = names_.find({object.slot, object.generation});
    return found == names_.end() ? "nobody" : found->second;
  }
  void set_rule(const Edit& edit) {
    if (edit.a.empty())
      world_->set_default_rule(edit.rule);
    else if (edit.b.empty())
      world_->set_group_rule("some", "some", edit.rule);
    else
      world_->set_pair_rule(object(edit.a), object(edit.b), edit.rule);
  }

  std::unique_ptr<ContactWorld> world_;
  bool has_levels_ = false;
  std::map<std::string, ObjectHandle> objects_;
  std::map<std::string, MechanismHandle> arms_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::string> names_;
};

/// The objects of a world by their names, and the edits of them.
class Script {
 public:
  explicit Script(std::uint64_t seed) : random_(seed) {}

  Random& random() { return random_; }
  /// The world as it is registered; then who carries whom at first.
  std::vector<Edit> draw_registration() {
    std::vector<Edit> out;
    const int arms = random_.one_in(4) ? 2 : 1;
    for (int i = 0; i < arms; ++i) out.push_back(draw_arm());
    for (std::uint32_t left = 8 + random_.below(12); left > 0; --left) out.push_back(draw_body());
    return out;
  }
  std::vector<Edit> draw_first_latches() {
    touched_.clear();
    std::vector<Edit> out;
    for (int i = 0; i < 4; ++i) draw_latch(out);
    return out;
  }
  /// No two are about one name, so that any order will do.
  std::vector<Edit> draw_edits() {
    touched_.clear();
    std::vector<Edit> out;
    // No edits in half of the frames, up to four in the others.
    if (random_.one_in(2)) return out;
    for (std::uint32_t left = 1 + random_.below(4); left > 0; --left) {
      switch (random_.below(10)) {
        case 9:
          draw_arm_edit(out);
          break;
        case 0:
        case 1:
          out.push_back(draw_body());
          break;
        case 2:
          draw_removal(out);
          break;
        case 3:
          draw_latch(out);
          break;
        case 4:
        case 5:
          draw_unlatch(out);
          break;
        case 6:
          draw_exemption(out);
          break;
        case 7:
          draw_switch(out);
          break;
        default:
          draw_rule_edit(out);
      }
    }
    return out;
  }

  std::vector<ObjectCommand> draw_commands(const Flight& flight) {
    std::vector<ObjectCommand> out;
    for (const auto& [name, body] : bodies_) {
      if (body.is_static || body.is_link || !body.flies) continue;
      const Pose& X = flight.world().actual_pose(flight.object(name));
      const Vector3 home = 0.1 * (Vector3(2.5, 0.5, 0) - X.p);
      out.push_back({name, RigidPath::by(X, home + random_.vector(0.3), random_.vector(0.3))});
    }
    return out;
  }
  std::vector<ArmCommand> draw_joints(const Flight& flight) {
    std::vector<ArmCommand> out;
    for (const std::string& arm : arms_) {
      if (random_.one_in(5)) continue;
      std::vector<double> values = joints_of(flight.world(), flight.arm(arm));
      for (double& q : values) q = std::clamp(q + random_.uniform(-0.3, 0.3), -1.5, 1.5);
      out.push_back({arm, values});
    }
    return out;
  }
  std::vector<std::string> names() const {
    std::vector<std::string> out;
    for (const auto& [name, body] : bodies_) out.push_back(name);
    return out;
  }
  const std::vector<std::string>& arms() const { return arms_; }

 private:
  struct Body {
    bool is_static = false, is_link = false, flies = false, is_on = true;
    std::string carrier = {};
    int carries = 0;
  };

  Edit draw_arm() {
    const int index = arm_count_++;
    Edit edit{Edit::Kind::add_arm, "arm " + std::to_string(index)};
    edit.X_WO = at(0, 2.2 * index, 0.05 * index);
    edit.in_group = index % 2 == 0;  // held by a hand
    arms_.push_back(edit.a);
    for (int k = 1; k <= kBars; ++k) bodies_[edit.a + "." + std::to_string(k)].is_link = true;
    return edit;
  }
  Edit draw_body() {
    Edit edit{Edit::Kind::add, "body " + std::to_string(count_++)};
    std::vector<PlacedHexahedron> solids;
    for (std::uint32_t left = random_.one_in(4) ? 3 : 1; left > 0; --left)
      solids.push_back({"solid " + std::to_string(left), random_solid(random_, random_.one_in(3) ? 0.2 : 0.6),
                        at(0.3 * (left - 1), 0, 0)});
    edit.tree = std::make_shared<HexahedronTree>(solids, edit.a);
    edit.X_WO = at(random_.uniform(0.5, 6.0), random_.uniform(-2.0, 3.0), random_.uniform(-0.3, 0.3));
    if (random_.one_in(2)) edit.X_WO.R = rotation_about(Vector3::UnitZ(), random_.uniform(-1, 1));
    edit.is_static = random_.one_in(4), edit.in_group = random_.one_in(3);
    Body& body = bodies_[edit.a];
    body.is_static = edit.is_static, body.flies = random_.one_in(2);
    touched_.insert(edit.a);
    return edit;
  }
  std::string any_name() {
    auto place = bodies_.begin();
    std::advance(place, random_.below(static_cast<std::uint32_t>(bodies_.size())));
    return place->first;
  }
  bool are_free(const std::string& a, const std::string& b) const {
    return a != b && !touched_.contains(a) && !touched_.contains(b);
  }
  void touch(const std::string& a, const std::string& b) { touched_.insert(a), touched_.insert(b); }

  void draw_removal(std::vector<Edit>& out) {
    const std::string a = any_name();
    const Body& body = bodies_.at(a);
    if (touched_.contains(a) || body.is_link || !body.carrier.empty() || body.carries > 0) return;
    out.push_back({Edit::Kind::remove, a});
    forget(a);
  }
  /// An arm goes that carries nothing; or one comes.
  void draw_arm_edit(std::vector<Edit>& out) {
    if (!random_.one_in(4)) return;
    if (arms_.size() < 2) {
      out.push_back(draw_arm());
      for (int k = 1; k <= kBars; ++k) touched_.insert(out.back().a + "." + std::to_string(k));
      return;
    }
    const std::string arm = arms_.front();
    std::vector<std::string> links;
    for (int k = 1; k <= kBars; ++k) links.push_back(arm + "." + std::to_string(k));
    for (const std::string& link : links)
      if (touched_.contains(link) || bodies_.at(link).carries > 0) return;
    for (const std::string& link : links) forget(link);
    arms_.erase(arms_.begin());
    out.push_back({Edit::Kind::remove_arm, arm});
  }
  void forget(const std::string& name) {
    std::erase_if(exempt_, [&](const auto& pair) { return pair.first == name || pair.second == name; });
    bodies_.erase(name);
    touched_.insert(name);
  }
  void draw_latch(std::vector<Edit>& out) {
    const std::string carrier = any_name(), carried = any_name();
    Body& body = bodies_.at(carried);
    if (!are_free(carrier, carried) || body.is_static || body.is_link || !body.carrier.empty()) return;
    for (std::string up = carrier; !up.empty(); up = bodies_.at(up).carrier)
      if (up == carried) return;
    body.carrier = carrier;
    ++bodies_.at(carrier).carries;
    out.push_back({Edit::Kind::latch, carrier, carried});
    touch(carrier, carried);
  }
  void draw_unlatch(std::vector<Edit>& out) {
    std::vector<std::string> carried;
    for (const auto& [name, body] : bodies_)
      if (!body.carrier.empty() && are_free(name, body.carrier)) carried.push_back(name);
    if (carried.empty()) return;
    const std::string a = carried[random_.below(static_cast<std::uint32_t>(carried.size()))];
    std::string& carrier = bodies_.at(a).carrier;
    touch(a, carrier);
    --bodies_.at(carrier).carries;
    carrier.clear();
    out.push_back({Edit::Kind::unlatch, a});
  }
  void draw_exemption(std::vector<Edit>& out) {
    if (!exempt_.empty() && random_.one_in(2)) {
      const auto [a, b] = exempt_.back();
      if (!are_free(a, b)) return;
      exempt_.pop_back();
      out.push_back({Edit::Kind::unexempt, a, b});
      touch(a, b);
      return;
    }
    const std::string a = any_name(), b = any_name();
    if (!are_free(a, b)) return;
    for (const auto& pair : exempt_)
      if (pair == std::pair{a, b} || pair == std::pair{b, a}) return;
    exempt_.emplace_back(a, b);
    out.push_back({Edit::Kind::exempt, a, b});
    touch(a, b);
  }
  void draw_switch(std::vector<Edit>& out) {
    const std::string a = any_name();
    if (touched_.contains(a)) return;
    bool& is_on = bodies_.at(a).is_on;
    is_on = !is_on;
    out.push_back({is_on ? Edit::Kind::switch_on : Edit::Kind::switch_off, a});
    touched_.insert(a);
  }
  void draw_rule_edit(std::vector<Edit>& out) {
    Edit edit{Edit::Kind::rule, ""};
    edit.rule = draw_rule(random_);
    switch (random_.below(3)) {
      case 0:
        break;
      case 1:
        edit.a = "some";
        break;
      default:
        edit.a = any_name(), edit.b = any_name();
        if (!are_free(edit.a, edit.b)) return;
        touch(edit.a, edit.b);
    }
    if (edit.b.empty() && !touched_.insert("rule of " + edit.a).second) return;
    out.push_back(edit);
  }

  Random random_;
  int count_ = 0, arm_count_ = 0;
  std::map<std::string, Body> bodies_;
  std::vector<std::string> arms_;
  std::vector<std::pair<std::string, std::string>> exempt_;
  std::set<std::string> touched_;
};

/// In an order of its own: 0 as drawn, 1 backward, else at random.
template <class T>
std::vector<T> in_order(std::vector<T> list, int order, Random& random) {
  if (order == 1) std::reverse(list.begin(), list.end());
  for (std::size_t i = list.size(); order > 1 && i > 1; --i)
    std::swap(list[i - 1], list[random.below(static_cast<std::uint32_t>(i))]);
  return list;
}

std::string first_difference(const std::vector<std::string>& a, const std::vector<std::string>& b) {
  const auto [in_a, in_b] = std::mismatch(a.begin(), a.end(), b.begin(), b.end());
  return "event " + (in_a == a.end() ? std::string("none") : *in_a) + " against " +
         (in_b == b.end() ? std::string("none") : *in_b);
}

/// One world's flights beside each other.
class Comparison {
 public:
  Comparison(std::uint64_t seed, OrderFigures& figures)
      : seed_(seed), script_(seed), shuffle_(seed + 1000003), figures_(figures) {
    flights_[3].world().set_threads(2);
    flights_[4].use_levels();
  }

  void fly() {
    const PairRule first_rule = draw_rule(script_.random());
    SlideBudget budget;
    if (script_.random().one_in(4)) budget.pairs = 5 + script_.random().below(60);
    if (script_.random().one_in(4)) budget.mover_work = script_.random().below(400);
    for (Flight& flight : flights_) {
      flight.world().set_default_rule(first_rule);
      flight.world().set_slide_budget(budget);
      if (seed_ % 2 == 0) flight.world().set_default_hand(std::nullopt);
    }
    apply(script_.draw_registration());
    apply(script_.draw_first_latches());
    for (int frame = 0; frame < kFrames; ++frame) {
      if (frame > 0) apply(script_.draw_edits());
      if (!fly_frame(frame)) return;
    }
  }

 private:
  static constexpr int kFlights = 5;
  static int order_of(int flight) { return flight >= 3 ? 0 : flight; }

  void apply(const std::vector<Edit>& edits) {
    figures_.edits += edits.size();
    for (int i = 0; i < kFlights; ++i)
      for (const Edit& edit : in_order(edits, order_of(i), shuffle_)) flights_[i].apply(edit);
  }

  bool fly_frame(int frame) {
    const std::vector<ObjectCommand> object_commands = script_.draw_commands(flights_[0]);
    const std::vector<ArmCommand> joints = script_.draw_joints(flights_[0]);
    std::vector<std::string> first_events;
    for (int i = 0; i < kFlights; ++i) {
      const FrameReport report = flights_[i].fly(in_order(object_commands, order_of(i), shuffle_),
                                                 in_order(joints, order_of(i), shuffle_));
      const std::vector<std::string> events = flights_[i].events_of(report);
      if (i == 0) first_events = events, count(report);
      if (i > 0 && !compare(i, frame)) return false;
      if (events != first_events) return differs(i, frame, first_difference(first_events, events), 0.0);
    }
    return true;
  }

  void count(const FrameReport& report) {
    ++figures_.frames;
    figures_.slid += report.slide_steps > 0;
    bool arm_slid = false;
    for (const std::string& arm : script_.arms()) {
      const MechanismHandle handle = flights_[0].arm(arm);
      const auto actual = flights_[0].world().joint_values(handle);
      const auto commanded = flights_[0].world().commanded_joints(handle);
      arm_slid = arm_slid || !std::equal(actual.begin(), actual.end(), commanded.begin());
    }
    figures_.arms_slid += arm_slid && report.slide_steps > 0;
    for (const ContactEvent& event : report.events)
      figures_.overlaps += event.kind == EventKind::penetrating_at_start;
  }

  bool compare(int flight, int frame) {
    const ContactWorld &a = flights_[0].world(), &b = flights_[flight].world();
    double worst = 0.0;
    std::string who;
    const auto look = [&](const std::string& name, const Pose& X, const Pose& Y) {
      if (is_same(X, Y)) return;
      const double by = norm(X.p - Y.p);
      if (who.empty() || by > worst) worst = by, who = name;
    };
    for (const std::string& name : script_.names()) {
      const ObjectHandle of_a = flights_[0].object(name), of_b = flights_[flight].object(name);
      look(name, a.actual_pose(of_a), b.actual_pose(of_b));
      for (std::size_t part = 0; part < a.executed_parts(); ++part)
        for (const double s : {0.5, 1.0})
          look(name, a.executed_pose(of_a, part, s), b.executed_pose(of_b, part, s));
    }
    for (const std::string& arm : script_.arms())
      if (joints_of(a, flights_[0].arm(arm)) != joints_of(b, flights_[flight].arm(arm)) && who.empty())
        who = arm;
    if (who.empty() && a.executed_parts() == b.executed_parts()) return true;
    return differs(flight, frame, who.empty() ? "parts" : who, worst);
  }

  bool differs(int flight, int frame, const std::string& what, double by) {
    figures_.findings.push_back({seed_, frame, what + ", flight " + std::to_string(flight), by});
    return false;
  }

  std::uint64_t seed_;
  Script script_;
  Random shuffle_;
  OrderFigures& figures_;
  std::array<Flight, kFlights> flights_;
};

}  // namespace

OrderFigures fly_edited_worlds(std::uint64_t seed, std::uint64_t worlds) {
  OrderFigures figures;
  for (; figures.worlds < worlds; ++figures.worlds) Comparison(seed + figures.worlds, figures).fly();
  return figures;
}

void print(std::ostream& out, const OrderFigures& figures) {
  out << figures.worlds << " worlds, " << figures.frames << " frames, " << figures.edits << " edits, "
      << figures.overlaps << " overlaps at start; slid in " << figures.slid << " frames, arms in "
      << figures.arms_slid << "\n"
      << figures.findings.size() << " differ\n";
  for (const OrderFinding& finding : figures.findings)
    out << "  seed " << finding.seed << " frame " << finding.frame << ": " << finding.what << ", by "
        << finding.by << " m\n";
}

}  // namespace touchstone
