/* An engine as a process, binary protocol: `native` through touchstone.h. With the argument "nothing" it answers each
   pair with unsupported, which shows what the protocol costs. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "touchstone/adapters/c_interface/touchstone.h"

typedef struct { uint32_t kind, count, batch, query, max_points, reserved; double max_separation, max_point_separation; } Head;
typedef struct { uint32_t a, b; touchstone_pose X_WA, X_WB; } Pair;
typedef struct { uint32_t first, second; } TwoWords;

static void* room(void* old, size_t bytes) { /* grows, and ends the program where it cannot */
  void* memory = realloc(old, bytes + 1);
  if (memory == NULL) exit(3);
  return memory;
}
static void need(touchstone_code code) {
  if (code == TOUCHSTONE_OK) return;
  fprintf(stderr, "%s\n", touchstone_error());
  exit(4);
}
static char* put(char* to, const void* bytes, size_t count) { return (char*)memcpy(to, bytes, count) + count; }

int main(int argc, char** argv) {
  const int nothing = argc > 1 && strcmp(argv[1], "nothing") == 0;
  touchstone_narrowphase* native;
  touchstone_workspace* scratch;
  need(touchstone_create("native", &native)), need(touchstone_create_workspace(native, &scratch));
  printf("{\"touchstone\": 1, \"name\": \"engine_c\", \"format\": \"binary\", \"distance\": true, \"penetration\": true, "
         "\"manifold\": true, \"relative_resolution\": 3.6e-15}\n");
  fflush(stdout);

  // Rooms that grow with what is asked.
  double* corners = NULL;
  Pair* asked = NULL;
  touchstone_pose* poses = NULL;
  touchstone_status status;
  touchstone_geometry geometry = {0};
  touchstone_point points[TOUCHSTONE_MAX_POINTS];
  memset(points, 0, sizeof points);
  char* reply = NULL;
  size_t solids = 0;
  // A message a turn, until the input ends.
  for (Head head; fread(&head, sizeof head, 1, stdin) == 1;) {
    // Solids to build.
    if (head.kind == 1) {
      solids = head.count;
      corners = room(corners, solids * 24 * sizeof(double)), poses = room(poses, solids * sizeof(touchstone_pose));
      if (fread(corners, 24 * sizeof(double), solids, stdin) != solids) return 1;
      if (!nothing) need(touchstone_build(native, corners, solids));
      continue;
    }
    // Pairs to answer: read all, answer one by one, write all at once.
    asked = room(asked, head.count * sizeof(Pair));
    if (fread(asked, sizeof(Pair), head.count, stdin) != head.count) return 1;
    const size_t geometry_bytes = head.query == TOUCHSTONE_OVERLAP ? 0 : sizeof geometry;
    const size_t point_bytes = head.max_points * sizeof(touchstone_point);
    reply = room(reply, sizeof(TwoWords) + head.count * (sizeof(TwoWords) + geometry_bytes + point_bytes));
    char* end = put(reply, &(TwoWords){head.batch, head.count}, sizeof(TwoWords));
    for (uint32_t i = 0; i < head.count; ++i) {
      status = TOUCHSTONE_UNSUPPORTED;
      if (!nothing) {
        poses[asked[i].a] = asked[i].X_WA, poses[asked[i].b] = asked[i].X_WB;
        const touchstone_pair pair = {asked[i].a, asked[i].b};
        const touchstone_query query = {(int32_t)head.query, (int32_t)head.max_points, head.max_separation, head.max_point_separation};
        const touchstone_input input = {&pair, 1, poses, solids, query};
        need(touchstone_evaluate(native, scratch, &input, &(touchstone_output){&status, &geometry, points}));
      }
      end = put(end, &(TwoWords){i, status}, sizeof(TwoWords));
      end = put(put(end, &geometry, geometry_bytes), points, point_bytes);
    }
    fwrite(reply, 1, (size_t)(end - reply), stdout);
    fflush(stdout);
  }
  // The input has ended.
  free(corners), free(asked), free(poses), free(reply);
  touchstone_destroy_workspace(scratch), touchstone_destroy(native);
  return 0;
}
