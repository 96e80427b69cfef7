/* An engine that goes wrong on pairs whose b is 31, as its first argument says; all others it calls separated. The second
 * argument, if any, is json: it then speaks that format. */
#define _POSIX_C_SOURCE 200809L
#include <inttypes.h>
#include <math.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
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
  if (strcmp(how, "slow") == 0) nanosleep(&(struct timespec){0, 500000000}, NULL); /* then it is right */
  if (strcmp(how, "hang") == 0) for (;;) pause();
  if (strcmp(how, "close") == 0) { fclose(stdout); close(STDOUT_FILENO); for (;;) pause(); }
}

static unsigned long long field(const char* line, const char* key) {
  const char* at = strstr(line, key);
  return at == NULL ? 0 : strtoull(at + strlen(key), NULL, 10);
}

/* What is written for a pair goes out at once, so that nobody reads a part of it. */
static int answer_lines(const char* how) {
  static char line[1 << 16];
  while (fgets(line, sizeof line, stdin) != NULL) {
    if (strncmp(line, "{\"solids\"", 9) == 0) {
      while (strchr(line, '\n') == NULL)
        if (fgets(line, sizeof line, stdin) == NULL) return 1;
      continue;
    }
    const int is_wrong = field(line, "\"b\":") == 31;
    const uint64_t pair = field(line, "\"pair\":");
    const char* rest = "\"status\":\"separated\",\"separation\":1,\"n_AB_W\":[1,0,0],\"p_A_W\":[0,0,0],\"p_B_W\":[1,0,0]";
    const char *fraction = "", *points = "";
    if (is_wrong) {
      go_wrong(how);
      if (strcmp(how, "short") == 0) {
        printf("{\"pair\":%" PRIu64 ",\"sta", pair);
        return 0;
      }
      if (strcmp(how, "fraction") == 0) fraction = ".5";
      if (strcmp(how, "feature") == 0)
        points = "{\"p_A_W\":[0,0,0],\"p_B_W\":[1,0,0],\"separation\":1,\"feature_id\":1e300}";
    }
    printf("{\"pair\":%" PRIu64 "%s,%s,\"points\":[%s]}\n", pair + (is_wrong && strcmp(how, "order") == 0), fraction, rest, points);
    if (is_wrong && strcmp(how, "extra") == 0) printf("{\"pair\":%" PRIu64 ",%s}\n", pair + 1, rest);
    fflush(stdout);
  }
  return 0;
}

int main(int argc, char** argv) {
  const char* how = argc > 1 ? argv[1] : "";
  const int is_json = argc > 2 && strcmp(argv[2], "json") == 0;
  if (strcmp(how, "silent") == 0) for (;;) pause();
  if (strcmp(how, "chatter") == 0) for (;;) write_all("hello, hello, hello ", 20);
  const char* version = strcmp(how, "version") == 0 ? "2" : "1";
  printf("{\"touchstone\": %s, \"name\": \"bad\", \"format\": \"%s\", \"distance\": true, \"penetration\": true, \"manifold\": %s}\n",
         version, is_json ? "json" : "binary", is_json ? "true" : "false");
  fflush(stdout);
  if (is_json) return answer_lines(how);
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
