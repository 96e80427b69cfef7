/* Two unit cubes, 0.5 m apart along x, through the C interface; then one is moved against the other. Ends with 0 where all is as it should be. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "touchstone/adapters/c_interface/touchstone.h"
#include "touchstone/adapters/c_interface/touchstone_plugin.h"

static void must(int holds, const char* what) {
  if (holds) return;
  fprintf(stderr, "%s: %s\n", what, touchstone_error());
  exit(1);
}

/* By a hand of 200 N/m, off the face by what is left of the step. */
static void slide_along(touchstone_world* world, touchstone_object mover, const touchstone_pose* goal) {
  const touchstone_hand hand = {*goal, 0, 0, {200.0, 200.0, 200.0}, {1.0, 1.0, 1.0}};
  const touchstone_slide_budget budget = {UINT64_MAX, INFINITY, TOUCHSTONE_MOVER_WORK};
  const touchstone_object* cut_off;
  const touchstone_feel* felt;
  size_t cuts, hands;
  touchstone_report report;
  touchstone_command command = {mover, *goal};
  command.X_WO.p[1] = 0.25;
  must(touchstone_set_policy(world, TOUCHSTONE_NO_OBJECT, TOUCHSTONE_NO_OBJECT, TOUCHSTONE_SLIDE, 0.0) == TOUCHSTONE_OK, "policy");
  must(touchstone_set_hand(world, mover, &hand) == TOUCHSTONE_OK, "hand");
  must(touchstone_set_slide_budget(world, &budget) == TOUCHSTONE_OK, "budget");
  must(touchstone_frame(world, &command, 1, &report) == TOUCHSTONE_OK, "frame");
  must(touchstone_get_cut_off(world, &cut_off, &cuts) == TOUCHSTONE_OK && cuts == 0, "cut off");
  must(touchstone_get_feels(world, &felt, &hands) == TOUCHSTONE_OK && hands == 1 && felt[0].object == mover, "feels");
  must(felt[0].lag_W[0] > 0.999 && felt[0].lag_W[0] < 1.001, "lag");
  must(felt[0].force_W[0] < -199.0 && felt[0].force_W[0] > -201.0, "force");
  touchstone_pose end;
  must(touchstone_get_poses(world, &mover, 1, &end) == TOUCHSTONE_OK, "poses");
  must(end.p[1] > 0.249 && end.p[1] < 0.251, "it slides along the wall");
  must(touchstone_select_group(world, "walls", 0) == TOUCHSTONE_OK, "selection");
  must(touchstone_frame(world, &command, 1, &report) == TOUCHSTONE_OK, "frame");
  must(touchstone_get_poses(world, &mover, 1, &end) == TOUCHSTONE_OK && end.p[0] > 1.49, "through a wall that is switched off");
}

static void move_against(const double* corners, const touchstone_pose* poses) {
  touchstone_world* world = NULL;
  touchstone_object mover, wall;
  touchstone_report report;
  must(touchstone_create_world("native", 0.0, &world) == TOUCHSTONE_OK, "world");
  const char* const walls[] = {"walls"};
  must(touchstone_add_object(world, "mover", corners, 1, &poses[0], 0, &mover) == TOUCHSTONE_OK, "mover");
  must(touchstone_add_object_in_groups(world, "wall", corners, 1, &poses[1], 1, walls, 1, &wall) == TOUCHSTONE_OK, "wall");
  must(touchstone_set_policy(world, TOUCHSTONE_NO_OBJECT, TOUCHSTONE_NO_OBJECT, TOUCHSTONE_ADVANCE, 0.0) == TOUCHSTONE_OK, "policy");
  const touchstone_command command = {mover, poses[1]};
  must(touchstone_frame(world, &command, 1, &report) == TOUCHSTONE_OK, "frame");
  must(report.blocked_movers == 1 && report.event_count > 0 && report.events[0].a == mover, "events");
  touchstone_pose end;
  must(touchstone_get_poses(world, &mover, 1, &end) == TOUCHSTONE_OK, "poses");
  must(end.p[0] > 0.499 && end.p[0] < 0.5, "it stops at the wall");
  slide_along(world, mover, &poses[1]);
  touchstone_destroy_world(world);
}

int main(void) {
  double corners[2][8][3];
  for (int i = 0; i < 16; ++i)
    for (int k = 0; k < 3; ++k) corners[i / 8][i % 8][k] = (i % 8 >> (2 - k) & 1) != 0 ? 0.5 : -0.5;
  const double at_origin[3] = {0.0, 0.0, 0.0}, beside[3] = {1.5, 0.0, 0.0}, no_turn[4] = {1.0, 0.0, 0.0, 0.0};
  const touchstone_pair pair = {0, 1};
  touchstone_pose poses[2];
  touchstone_status status;
  touchstone_geometry geometry;
  touchstone_narrowphase* narrowphase = NULL;
  touchstone_workspace* workspace = NULL;

  must(touchstone_abi_version() == TOUCHSTONE_ABI_VERSION, "version");
  must(touchstone_create("native", &narrowphase) == TOUCHSTONE_OK, "create");
  must(touchstone_build(narrowphase, &corners[0][0][0], 2) == TOUCHSTONE_OK, "build");
  must(touchstone_create_workspace(narrowphase, &workspace) == TOUCHSTONE_OK, "workspace");
  must(touchstone_pose_from_quaternion(at_origin, no_turn, &poses[0]) == TOUCHSTONE_OK, "pose");
  must(touchstone_pose_from_quaternion(beside, no_turn, &poses[1]) == TOUCHSTONE_OK, "pose");
  const touchstone_input input = {&pair, 1, poses, 2, {TOUCHSTONE_DISTANCE, 0, 10.0, 0.0}};
  const touchstone_output output = {&status, &geometry, NULL};
  must(touchstone_evaluate(narrowphase, workspace, &input, &output) == TOUCHSTONE_OK, "evaluate");
  must(status == TOUCHSTONE_SEPARATED, "status");
  must(geometry.separation > 0.4999 && geometry.separation < 0.5001, "separation");
  must(geometry.n_AB_W[0] > 0.9999, "normal");

  move_against(&corners[0][0][0], poses);
  must(touchstone_create("no_such_engine", &narrowphase) == TOUCHSTONE_BAD_INPUT, "unknown name");
  must(strstr(touchstone_error(), "native") != NULL, "the text names the known ones");
  touchstone_destroy_workspace(workspace);
  touchstone_destroy(narrowphase);
  return 0;
}
