#include "touchstone/contact_core/world/slide/slide_reach.hpp"

namespace touchstone {
namespace {

/// Rounding of distances and of poses.
constexpr double kUp = 1.0 + 0x1p-20;

/// How far a rigid slider may take what is in the sphere.
double rigid_reach(const WorldModel& model, const Slider& slider, const Sphere& sphere_W) {
  const Vector3 centre_W = transform(model.objects[slider.root].X_WO, slider.metric.centre);
  const double furthest = norm(sphere_W.centre - centre_W) + sphere_W.radius;
  return kUp * slider.distance * (1.0 + slider.turn_rate() * furthest);
}

}  // namespace

std::uint32_t other_link(const WorldModel& model, const Slider& slider, SolidIndex other) {
  return model.root_of(other) == slider.root ? model.objects[model.body_of(other)].link
                                             : slider.arm->mechanism->base();
}

Vector3 slide_centre(const WorldModel& model, const Slider& slider, SolidIndex solid) {
  if (slider.arm != nullptr) return slider.arm->X_WL[model.objects[model.body_of(solid)].link].p;
  return transform(model.objects[slider.root].X_WO, slider.metric.centre);
}

double slide_reach(const WorldModel& model, const Slider& slider, SolidIndex solid, SolidIndex other) {
  const Vector3 centre_W = slide_centre(model, slider, solid);
  const Sphere& sphere = model.layout.solids[solid].bounding_sphere();
  const double furthest = norm(transform(model.from[solid], sphere.centre) - centre_W) + sphere.radius;
  if (slider.arm == nullptr) return kUp * slider.distance * (1.0 + slider.turn_rate() * furthest);
  return kUp * slider.distance *
         slider.arm->frame.reach(model.objects[model.body_of(solid)].link, other_link(model, slider, other),
                                 furthest, slider.arm->weights);
}

double reach_of_pair(const WorldModel& model, const Slider& slider, const SolidPair& pair) {
  const auto [mover, obstacle] = model.mover_first(pair, slider.root);
  double reach = slide_reach(model, slider, mover, obstacle);
  if (model.root_of(obstacle) == slider.root) reach += slide_reach(model, slider, obstacle, mover);
  return reach;
}

bool needs_more_pairs(WorldModel& model, const Slider& slider, std::uint32_t slot) {
  Travels& travels = model.travels;
  if (const ObjectLevels* levels = model.layout.levels[slot]) {
    const Sphere sphere_W{transform(model.objects[slot].X_WO, levels->sphere_O().centre),
                          levels->sphere_O().radius};
    const double needed = 2.0 * (rigid_reach(model, slider, sphere_W) + travels.last_object[slot]);
    travels.needed_object[slot] = needed;
    return travels.of_object[slot] + needed > travels.object_limit[slot];
  }
  bool is_more_needed = false;
  model.for_each_solid_of(slot, [&](SolidIndex i) {
    const double needed = 2.0 * (slide_reach(model, slider, i, i) + travels.last_solid[i]);
    travels.needed[i] = needed;
    is_more_needed = is_more_needed || travels.of_solid[i] + needed > travels.solid_limit[i];
  });
  return is_more_needed;
}

void measure_plan(WorldModel& model, const Slider& slider) {
  Travels& travels = model.travels;
  model.for_each_member(slider.root, [&](std::uint32_t slot) {
    if (model.moves(slot))
      model.measure_travels(*slider.arm, slot, travels.planned_solid);
    else
      model.for_each_solid_of(slot, [&](SolidIndex solid) { travels.planned_solid[solid] = 0.0; });
  });
  model.measure_link_travels(*slider.arm, travels.planned_link_pair);
  slider.arm->planned_path = slider.arm->paths, slider.arm->planned_after = travels.clearings;
}

}  // namespace touchstone
