/* A scene file flown to its end, then a robot beside its objects; a scene with dynamics, pushed and set back. Arguments: SCENE.yaml
 * ROBOT.urdf DYNAMICS.yaml. Ends with 0 where all is as it should be. */
#include <stdio.h>
#include <stdlib.h>

#include "touchstone/adapters/c_files/touchstone_dynamics.h"

static void must(touchstone_code code, const char* what) {
  if (code == TOUCHSTONE_OK) return;
  fprintf(stderr, "%s: %s\n", what, touchstone_error());
  exit(1);
}

static double height_after(touchstone_simulation* run, size_t object, int steps) {
  touchstone_step step;
  touchstone_object_state states[64];
  while (steps-- > 0) must(touchstone_step_simulation(run, &step), "step");
  must(touchstone_get_object_states(run, states, object + 1), "states");
  return states[object].X_WO.p[2];
}

/* The last object of the file is a free body. */
static int run_dynamics(const char* file) {
  const double up[3] = {0, 0, 1e4};
  touchstone_simulation* run = NULL;
  touchstone_saved_run* saved = NULL;
  touchstone_simulation_facts facts;
  touchstone_object_state states[64];
  double pushed, left;
  size_t last;
  must(touchstone_load_simulation("native", file, NULL, 0, &run), "simulation");
  must(touchstone_get_simulation_facts(run, &facts), "facts");
  last = facts.objects - 1;
  must(touchstone_get_object_states(run, states, facts.objects), "states");
  must(touchstone_save_run(run, &saved), "save");
  must(touchstone_push_object(run, last, up, states[last].X_WO.p, NULL), "push");
  pushed = height_after(run, last, 5);
  must(touchstone_restore_run(run, saved), "restore");
  left = height_after(run, last, 5);
  touchstone_destroy_saved_run(saved);
  touchstone_destroy_simulation(run);
  return pushed > left ? 0 : 1;
}

int main(int argc, char** argv) {
  const touchstone_pose aside = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 50}};
  touchstone_world* world = NULL;
  touchstone_scene_facts facts;
  touchstone_report report;
  touchstone_mechanism robot;
  size_t objects = 0;
  uint64_t frame, blocked = 0;
  if (argc != 4 || touchstone_abi_version() != TOUCHSTONE_ABI_VERSION) return 2;
  must(touchstone_load_scene("native", argv[1], NULL, 0, &world), "scene");
  must(touchstone_get_scene_facts(world, &facts), "facts");
  must(touchstone_get_scene_object_count(world, &objects), "objects");
  for (frame = 1; frame < facts.frames; ++frame) { /* the first one is at time 0 */
    must(touchstone_step_scene(world, &report), "step");
    blocked += report.blocked_movers;
  }
  must(touchstone_add_robot(world, NULL, argv[2], NULL, &aside, NULL, 0, &robot), "robot");
  must(touchstone_prepare(world), "prepare");
  touchstone_destroy_world(world);
  printf("%zu objects, %.0f frames, %.0f stops\n", objects, (double)facts.frames, (double)blocked);
  return objects > 0 && blocked > 0 ? run_dynamics(argv[3]) : 1;
}
