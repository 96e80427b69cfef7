/* A scene file flown to its end, then a robot beside its objects. Arguments: SCENE.yaml ROBOT.urdf. Ends with 0 where all is as it should be. */
#include <stdio.h>
#include <stdlib.h>

#include "touchstone/adapters/c_files/touchstone_files.h"

static void must(touchstone_code code, const char* what) {
  if (code == TOUCHSTONE_OK) return;
  fprintf(stderr, "%s: %s\n", what, touchstone_error());
  exit(1);
}

int main(int argc, char** argv) {
  const touchstone_pose aside = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 50}};
  touchstone_world* world = NULL;
  touchstone_scene_facts facts;
  touchstone_report report;
  touchstone_mechanism robot;
  size_t objects = 0;
  uint64_t frame, blocked = 0;
  if (argc != 3 || touchstone_abi_version() != TOUCHSTONE_ABI_VERSION) return 2;
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
  return objects > 0 && blocked > 0 ? 0 : 1;
}
