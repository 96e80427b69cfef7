/* A plug-in that answers nonsense, another kind for each pair; see plugin_test.cpp. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "touchstone_plugin.h"

#ifndef ABI_VERSION
#define ABI_VERSION TOUCHSTONE_ABI_VERSION
#endif
#ifndef DESCRIPTION
#define DESCRIPTION "answers nonsense"
#endif
#ifndef MOST_SOLIDS
#define MOST_SOLIDS 1000
#endif

static int instance;

static void* create(void) { return &instance; }
static void destroy(void* self) { (void)self; }
static int build(void* self, const double* corners, size_t solids, char* error, size_t error_size) {
  (void)self, (void)corners;
  if (solids < MOST_SOLIDS) return 0;
#ifdef UNTIDY
  memset(error, 0xFE, error_size); /* neither text nor ended */
  return 1;
#endif
  snprintf(error, error_size, "solid %zu is one too many", solids - 1);
  return 1;
}
static void* create_workspace(const void* self) { return (void)self, NULL; }
static void destroy_workspace(void* workspace) { (void)workspace; }
static void evaluate(const void* self, void* workspace, const touchstone_input* in, const touchstone_output* out) {
  (void)self, (void)workspace;
  for (size_t i = 0; i < in->pair_count; ++i) {
    if (i == 0) continue; /* not written */
    out->status[i] = i == 1 ? 200 : TOUCHSTONE_OVERLAPPING;
    if (in->query.kind == TOUCHSTONE_OVERLAP) continue;
    const touchstone_geometry good = {-1.0, {1.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {-1.0, 0.0, 0.0}, 0, 0};
    out->geometry[i] = good;
    if (i == 2) out->geometry[i].separation = NAN;
    if (i == 3) out->geometry[i].n_AB_W[0] = 0.0;
    if (i == 4) out->geometry[i].point_count = 1000000;
  }
}
static void crash(const void* self, void* workspace, const touchstone_input* in, const touchstone_output* out) {
  if (in->pair_count > 31) raise(SIGSEGV);
  evaluate(self, workspace, in, out);
}
static void hang(const void* self, void* workspace, const touchstone_input* in, const touchstone_output* out) {
  while (in->pair_count > 31) pause();
  evaluate(self, workspace, in, out);
}
void (*each_is_used[3])(const void*, void*, const touchstone_input*, const touchstone_output*) = {evaluate, crash, hang};
#ifdef HANG_AT_LOAD
__attribute__((constructor)) static void hang_at_load(void) {
  for (;;) pause();
}
#endif
#ifndef EVALUATE
#define EVALUATE evaluate
#endif
#ifndef RESOLUTION
#define RESOLUTION 0.0
#endif
#ifndef NAME
#define NAME "bad"
#endif

const touchstone_backend touchstone_plugin = {
    ABI_VERSION, sizeof(touchstone_backend), NAME, DESCRIPTION,
    {.distance = 1, .penetration = 1, .manifold = 1, .scalar_bits = 64, .absolute_resolution = RESOLUTION},
    create, destroy, build, create_workspace, destroy_workspace, EVALUATE};
