/* A plug-in in C: overlap only, by face normals and crossed edges as axes, undecided near touching.
   cc -std=c11 -O2 -fPIC -shared -I FOLDER_OF_touchstone_plugin.h -o libseparating_axes.so separating_axes.c -lm */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "touchstone_plugin.h"

static const int kFaces[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
static const int kEdges[12][2] = {{0, 4}, {1, 5}, {2, 6}, {3, 7}, {0, 2}, {1, 3}, {4, 6}, {5, 7}, {0, 1}, {2, 3}, {4, 5}, {6, 7}};

typedef struct { double* corners; } Solids;
typedef struct { double v[8][3], reach; } Placed; /* about A's origin, so that coordinates are small */

static void sub(const double a[3], const double b[3], double out[3]) { for (int k = 0; k < 3; ++k) out[k] = a[k] - b[k]; }
static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static double cross(const double a[3], const double b[3], double n[3]) { /* made a unit vector; its length before */
  n[0] = a[1] * b[2] - a[2] * b[1], n[1] = a[2] * b[0] - a[0] * b[2], n[2] = a[0] * b[1] - a[1] * b[0];
  const double length = sqrt(dot(n, n));
  for (int k = 0; k < 3 && length > 0; ++k) n[k] /= length;
  return length;
}
static Placed place(const double* corners, const touchstone_pose* X, const double origin[3]) {
  Placed out = {.reach = 0};
  for (int i = 0; i < 24; ++i) {
    const double *c = corners + i / 3 * 3, *R = X->R + i % 3;
    out.v[i / 3][i % 3] = R[0] * c[0] + R[3] * c[1] + R[6] * c[2] + (X->p[i % 3] - origin[i % 3]);
    out.reach = fmax(out.reach, fabs(out.v[i / 3][i % 3]));
  }
  return out;
}
static double gap_along(const Placed* a, const Placed* b, const double n[3]) {
  double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
  for (int i = 0; i < 16; ++i) {
    const double x = dot((i < 8 ? a : b)->v[i % 8], n);
    low[i / 8] = fmin(low[i / 8], x), high[i / 8] = fmax(high[i / 8], x);
  }
  return fmax(low[1] - high[0], low[0] - high[1]);
}
static touchstone_status check(const Placed* a, const Placed* b, double moved) {
  const double size = fmax(a->reach, b->reach), rounding = 4e-15 * size + 1e-15 * moved;
  double widest = -INFINITY, e[2][12][3], n[3], d[2][3];
  for (int s = 0; s < 2; ++s) {
    const Placed* solid = s == 0 ? a : b;
    for (int f = 0; f < 6; ++f) {
      sub(solid->v[kFaces[f][2]], solid->v[kFaces[f][0]], d[0]), sub(solid->v[kFaces[f][3]], solid->v[kFaces[f][1]], d[1]);
      if (!(cross(d[0], d[1], n) > 0)) continue; /* a collapsed face */
      widest = fmax(widest, gap_along(a, b, n));
    }
    for (int i = 0; i < 12; ++i) sub(solid->v[kEdges[i][1]], solid->v[kEdges[i][0]], e[s][i]);
  }
  for (int i = 0; i < 144 && widest <= rounding; ++i) {
    const double *u = e[0][i / 12], *w = e[1][i % 12], lengths = sqrt(dot(u, u) * dot(w, w));
    if (cross(u, w, n) > 1e-6 * lengths) widest = fmax(widest, gap_along(a, b, n) * (1 - 1e-6) - 1e-9 * size);
  }
  if (widest > rounding) return TOUCHSTONE_SEPARATED;
  return widest < -rounding - 4e-6 * size ? TOUCHSTONE_OVERLAPPING : TOUCHSTONE_UNDECIDED;
}

static void* create(void) { return calloc(1, sizeof(Solids)); }
static void destroy(void* self) { free(((Solids*)self)->corners), free(self); }
static int build(void* self, const double* corners, size_t solids, char* error, size_t error_size) {
  double* copy = malloc(solids * 24 * sizeof(double) + 1);
  if (copy == NULL) return strncpy(error, "no memory", error_size), 1;
  memcpy(copy, corners, solids * 24 * sizeof(double));
  free(((Solids*)self)->corners), ((Solids*)self)->corners = copy;
  return 0;
}
static void* create_workspace(const void* self) { return (void)self, NULL; }
static void destroy_workspace(void* workspace) { (void)workspace; }
static void evaluate(const void* self, void* workspace, const touchstone_input* in, const touchstone_output* out) {
  (void)workspace;
  for (size_t i = 0; i < in->pair_count; ++i) {
    const touchstone_pose *X_WA = in->poses + in->pairs[i].a, *X_WB = in->poses + in->pairs[i].b;
    const double* corners = ((const Solids*)self)->corners;
    const Placed a = place(corners + 24 * (size_t)in->pairs[i].a, X_WA, X_WA->p), b = place(corners + 24 * (size_t)in->pairs[i].b, X_WB, X_WA->p);
    double moved = 0, sum = 0;
    for (int k = 0; k < 3; ++k) moved = fmax(moved, fmax(fabs(X_WA->p[k]), fabs(X_WB->p[k])));
    for (int k = 0; k < 24; ++k) sum += (&a.v[0][0])[k] - (&a.v[0][0])[k] + (&b.v[0][0])[k] - (&b.v[0][0])[k];
    const touchstone_status answer = sum == 0 ? check(&a, &b, moved) : TOUCHSTONE_FAILED; /* no finite pose */
    out->status[i] = in->query.kind == TOUCHSTONE_OVERLAP ? answer : TOUCHSTONE_UNSUPPORTED;
  }
}

const touchstone_backend touchstone_plugin = {
    TOUCHSTONE_ABI_VERSION, sizeof(touchstone_backend), "separating_axes_c", "plug-in in C; overlap only",
    {.overlap_complete = 1, .deterministic = 1, .thread_safe = 1, .scalar_bits = 64, .relative_resolution = 1e-5},
    create, destroy, build, create_workspace, destroy_workspace, evaluate};
