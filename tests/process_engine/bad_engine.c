/* An engine that goes wrong on pairs whose b is 31, as its argument says; all others it calls separated. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "touchstone/adapters/c_interface/touchstone.h"

typedef struct { uint32_t kind, count, batch, query, max_points, reserved; double max_separation, max_point_separation; } Head;
typedef struct { uint32_t a, b; touchstone_pose X_WA, X_WB; } Pair;
typedef struct { uint32_t pair, status; touchstone_geometry geometry; } Answer;

static Pair asked[4096];
static Answer answers[4096];
static double skipped[24];

static void write_all(const void* bytes, size_t size) {
  fwrite(bytes, 1, size, stdout);
  fflush(stdout);
}

static void go_wrong(const char* how) {
  if (strcmp(how, "crash") == 0) {
    signal(SIGSEGV, SIG_DFL); /* a sanitizer's handler would end the program otherwise */
    raise(SIGSEGV);
  }
  if (strcmp(how, "exit") == 0) exit(7);
  if (strcmp(how, "hang") == 0) for (;;) pause();
  if (strcmp(how, "close") == 0) { fclose(stdout); close(STDOUT_FILENO); for (;;) pause(); }
}

int main(int argc, char** argv) {
  const char* how = argc > 1 ? argv[1] : "";
  if (strcmp(how, "silent") == 0) for (;;) pause();
  if (strcmp(how, "chatter") == 0) for (;;) write_all("hello, hello, hello ", 20);
  const char* version = strcmp(how, "version") == 0 ? "2" : "1";
  printf("{\"touchstone\": %s, \"name\": \"bad\", \"format\": \"binary\", \"distance\": true, \"penetration\": true}\n", version);
  fflush(stdout);
  for (Head head; fread(&head, sizeof head, 1, stdin) == 1;) {
    if (head.kind == 1) {
      for (uint32_t i = 0; i < head.count; ++i)
        if (fread(skipped, sizeof skipped, 1, stdin) != 1) return 1;
      continue;
    }
    if (fread(asked, sizeof(Pair), head.count, stdin) != head.count) return 1;
    uint32_t reply[2] = {head.batch, head.count};
    size_t count = head.count;
    for (uint32_t i = 0; i < head.count; ++i) {
      const touchstone_geometry good = {1.0, {1, 0, 0}, {0, 0, 0}, {1, 0, 0}, 0, 0};
      answers[i] = (Answer){i, TOUCHSTONE_SEPARATED, good};
      if (asked[i].b != 31) continue;
      go_wrong(how);
      if (strcmp(how, "nan") == 0) answers[i].geometry.separation = NAN;
      if (strcmp(how, "status") == 0) answers[i].status = 99;
      if (strcmp(how, "order") == 0) answers[i].pair = i + 1;
      if (strcmp(how, "batch") == 0) reply[0] += 1;
      if (strcmp(how, "short") == 0) count = i;
    }
    write_all(reply, sizeof reply);
    write_all(answers, count * sizeof(Answer));
    if (count < head.count) return 0;
    if (strcmp(how, "flood") == 0) for (;;) write_all(answers, sizeof answers);
  }
  return 0;
}
