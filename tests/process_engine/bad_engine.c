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
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "touchstone/adapters/c_interface/touchstone.h"

typedef struct { uint32_t kind, count, batch, query, max_points, reserved; double max_separation, max_point_separation; } Head;
typedef struct { uint32_t a, b; touchstone_pose X_WA, X_WB; } Pair;
typedef struct { uint32_t pair, status; touchstone_geometry geometry; } Answer;

static Pair asked[4096];
static Answer answers[4096];

static void write_all(const void* bytes, size_t size) {
  fwrite(bytes, 1, size, stdout);
  fflush(stdout);
}

/* A line of the greeting or of an answer, in other clothes. */
static void write_line(const char* line, const char* how) {
  if (strcmp(how, "bom") == 0) write_all("\xEF\xBB\xBF", 3);
  for (; *line != '\0'; ++line) {
    if (*line == '\n' && strcmp(how, "crlf") == 0) write_all("\r", 1);
    write_all(line, 1);
    if (strcmp(how, "utf16") == 0) write_all("\0", 1);
    if (strcmp(how, "dribble") == 0) nanosleep(&(struct timespec){0, 2000000}, NULL);
  }
}

static void write_endlessly(FILE* to) {
  for (;;) fputs("and on and on ", to);
}

/* Up to 512 MB, then there is no more. */
static void leak(void) {
  const struct rlimit limit = {512u << 20, 512u << 20};
  setrlimit(RLIMIT_AS, &limit);
  for (;;) memset(malloc(1 << 20), 1, 1 << 20);
}

static void leave_a_child(int in_a_session_of_its_own) {
  if (fork() == 0) {
    if (in_a_session_of_its_own) setsid();
    nanosleep(&(struct timespec){in_a_session_of_its_own ? 20 : 3600, 0}, NULL);
  }
  exit(7);
}

static void go_wrong(const char* how) {
  if (strcmp(how, "orphan") == 0) leave_a_child(0);
  if (strcmp(how, "orphan_of_its_own") == 0) leave_a_child(1);
  if (strcmp(how, "leak") == 0) leak();
  if (strcmp(how, "stop") == 0) raise(SIGSTOP);
  if (strcmp(how, "sleep") == 0) sleep(59);
  if (strcmp(how, "stderr") == 0) write_endlessly(stderr);
  if (strcmp(how, "print") == 0) printf("debug: pair 31\n");
  if (strcmp(how, "deaf") == 0) {
    signal(SIGTERM, SIG_IGN);
    for (;;) pause();
  }
  if (strcmp(how, "closed_input") == 0) {
    fclose(stdin), close(STDIN_FILENO);
    for (;;) pause();
  }
  if (strcmp(how, "crash") == 0) {
    signal(SIGSEGV, SIG_DFL); /* a sanitizer's handler would end the program otherwise */
    raise(SIGSEGV);
  }
  if (strcmp(how, "exit") == 0 || strcmp(how, "once") == 0) exit(7);
  if (strcmp(how, "slow") == 0) nanosleep(&(struct timespec){0, 500000000}, NULL); /* then it is right */
  if (strcmp(how, "hang") == 0) for (;;) pause();
  if (strcmp(how, "close") == 0) { fclose(stdout); close(STDOUT_FILENO); for (;;) pause(); }
}

/* Takes the bytes of solids, a page at a time and every 30 ms where it sips. */
static int take_solids(uint32_t count, const char* how) {
  static double page[480]; /* 20 solids */
  for (uint32_t left = count * 24; left > 0;) {
    const size_t now = left < 480 ? left : 480;
    if (strcmp(how, "sips") == 0) nanosleep(&(struct timespec){0, 30000000}, NULL);
    if (fread(page, sizeof(double), now, stdin) != now) return 1;
    left -= (uint32_t)now;
  }
  return 0;
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
      if (strcmp(how, "long") == 0) write_endlessly(stdout);
      if (strcmp(how, "deep") == 0) for (int i = 0; i < 16000; ++i) putchar('[');
      if (strcmp(how, "comma") == 0) rest = "\"status\":\"separated\",\"separation\":0,5";
      if (strcmp(how, "literal") == 0) rest = "\"status\":\"separated\",\"separation\":NaN";
      if (strcmp(how, "beyond") == 0) rest = "\"status\":\"separated\",\"separation\":1e400";
      if (strcmp(how, "text") == 0) rest = "\"status\":\"separated\",\"separation\":\"1\"";
      if (strcmp(how, "feature") == 0)
        points = "{\"p_A_W\":[0,0,0],\"p_B_W\":[1,0,0],\"separation\":1,\"feature_id\":1e300}";
    }
    char answer[512];
    snprintf(answer, sizeof answer, "{\"pair\":%" PRIu64 "%s,%s,\"points\":[%s]}\n", pair + (is_wrong && strcmp(how, "order") == 0),
             fraction, rest, points);
    if (strcmp(how, "crlf") == 0)
      write_line(answer, how);
    else
      fputs(answer, stdout);
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
  const char* resolution = strcmp(how, "resolution") == 0 ? ", \"absolute_resolution\": -1" : "";
  char greeting[256];
  snprintf(greeting, sizeof greeting,
           "{\"touchstone\": %s, \"name\": \"bad\", \"format\": \"%s\", \"distance\": true, \"penetration\": true, \"manifold\": %s%s}\n",
           version, is_json ? "json" : "binary", is_json ? "true" : "false", resolution);
  write_line(greeting, how);
  if (strcmp(how, "twice") == 0) write_line(greeting, how);
  if (strcmp(how, "early") == 0) write_all(answers, sizeof(Answer));
  if (is_json) return answer_lines(how);
  int sets = 0;
  for (Head head; fread(&head, sizeof head, 1, stdin) == 1;) {
    if (head.kind == 1) {
      if (strcmp(how, "once") == 0 && sets++ > 0) exit(7);
      if (take_solids(head.count, how) != 0) return 1;
      continue;
    }
    if (fread(asked, sizeof(Pair), head.count, stdin) != head.count) return 1;
    if (strcmp(how, "tires") == 0 && head.batch > 1) exit(7);
    if (strcmp(how, "nap") == 0) nanosleep(&(struct timespec){0, 100000000}, NULL);
    for (uint32_t i = 0; i < head.count && strcmp(how, "slow_pairs") == 0; ++i) nanosleep(&(struct timespec){0, 10000000}, NULL);
    uint32_t reply[2] = {head.batch, head.count};
    size_t count = head.count;
    for (uint32_t i = 0; i < head.count; ++i) {
      const touchstone_geometry good = {1.0, {1, 0, 0}, {0, 0, 0}, {1, 0, 0}, 0, 0};
      answers[i] = (Answer){i, TOUCHSTONE_SEPARATED, good};
      if (asked[i].b != 31) continue;
      go_wrong(how);
      if (strcmp(how, "nan") == 0) answers[i].geometry.separation = NAN;
      if (strcmp(how, "infinity") == 0) answers[i].geometry.separation = INFINITY;
      if (strcmp(how, "negative_zero") == 0) answers[i].geometry.separation = -0.0;
      if (strcmp(how, "denormal") == 0) answers[i].geometry.separation = 4.9e-324;
      if (strcmp(how, "huge") == 0) answers[i].geometry.separation = 1e300;
      if (strcmp(how, "changes") == 0) answers[i].geometry.separation = 1.0 + (double)(head.batch % 7u);
      if (strcmp(how, "count") == 0) reply[1] += 1;
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
