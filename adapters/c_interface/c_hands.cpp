#include "touchstone/adapters/c_interface/calls.hpp"
#include "touchstone/adapters/c_interface/world.hpp"

// A world's groups, slide budget and hands.

using namespace touchstone;
using c_interface::guarded;
using c_interface::number_of;
using c_interface::object_of;
using c_interface::pose_of;
using c_interface::require;
using c_interface::rule_of;

namespace {

static_assert(TOUCHSTONE_MOVER_WORK == kMoverWork);

void put(const Vector3& from, double (&to)[3]) {
  for (int axis = 0; axis < 3; ++axis) to[axis] = from[axis];
}

touchstone_feel feel_of(const HandFeel& felt) {
  touchstone_feel out{};
  out.object = number_of(felt.object);
  put(felt.p_W, out.p_W);
  put(felt.lag_W, out.lag_W);
  put(felt.turn_lag_W, out.turn_lag_W);
  put(felt.force_W, out.force_W);
  put(felt.moment_W, out.moment_W);
  return out;
}

std::optional<HandStiffness> hand_of(const touchstone_hand* hand) {
  if (hand == nullptr) return std::nullopt;
  HandStiffness out;
  if (hand->has_tool != 0) out.X_OT = pose_of(hand->X_OT);
  out.translation = {hand->translation[0], hand->translation[1], hand->translation[2]};
  out.turning = {hand->turning[0], hand->turning[1], hand->turning[2]};
  return out;
}

}  // namespace

void c_interface::keep_hands(touchstone_world& world, const FrameReport& report) {
  world.cut_off.clear();
  for (const ObjectHandle mover : report.cut_off) world.cut_off.push_back(number_of(mover));
  world.felt.clear();
  for (const HandFeel& felt : report.felt) world.felt.push_back(feel_of(felt));
}

touchstone_code touchstone_set_group_policy(touchstone_world* world, const char* first, const char* second,
                                            int32_t policy, double warn_distance) {
  return guarded({{world, "world"}, {first, "first"}, {second, "second"}},
                 [&] { world->world.set_group_rule(first, second, rule_of(policy, warn_distance)); });
}

touchstone_code touchstone_select_group(touchstone_world* world, const char* group, int32_t on) {
  return guarded({{world, "world"}, {group, "group"}},
                 [&] { world->world.select(SelectionChange::of_group(group, on != 0)); });
}

touchstone_code touchstone_set_slide_budget(touchstone_world* world, const touchstone_slide_budget* budget) {
  return guarded({{world, "world"}}, [&] {
    if (budget == nullptr)
      world->world.set_slide_budget({});
    else
      world->world.set_slide_budget({budget->pairs, budget->seconds, budget->mover_work});
  });
}

touchstone_code touchstone_get_slide_budget(const touchstone_world* world, touchstone_slide_budget* out) {
  return guarded({{world, "world"}, {out, "out"}}, [&] {
    const SlideBudget& budget = world->world.slide_budget();
    *out = {budget.pairs, budget.seconds, budget.mover_work};
  });
}

touchstone_code touchstone_get_cut_off(const touchstone_world* world, const touchstone_object** out,
                                       size_t* count) {
  return guarded({{world, "world"}, {static_cast<const void*>(out), "out"}, {count, "count"}}, [&] {
    *out = world->cut_off.data();
    *count = world->cut_off.size();
  });
}

touchstone_code touchstone_set_hand(touchstone_world* world, touchstone_object object,
                                    const touchstone_hand* hand) {
  return guarded({{world, "world"}}, [&] {
    if (object == TOUCHSTONE_NO_OBJECT)
      world->world.set_default_hand(hand_of(hand));
    else
      world->world.set_hand(object_of(object), hand_of(hand));
  });
}

touchstone_code touchstone_get_feels(const touchstone_world* world, const touchstone_feel** out,
                                     size_t* count) {
  return guarded({{world, "world"}, {static_cast<const void*>(out), "out"}, {count, "count"}}, [&] {
    *out = world->felt.data();
    *count = world->felt.size();
  });
}
