#ifndef TOUCHSTONE_PLUGIN_H
#define TOUCHSTONE_PLUGIN_H

/**
 * @file
 * A backend as a shared library, in C or anything that makes one: it includes this header (with touchstone.h
 * beside it), links nothing of ours, and defines one object:
 *
 *     const touchstone_backend touchstone_plugin = {TOUCHSTONE_ABI_VERSION, sizeof(touchstone_backend), ...};
 *
 *     cc -std=c11 -O2 -fPIC -shared -o libmine.so mine.c
 *     compare_backends --plugin ./libmine.so
 */

#include "touchstone.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A backend's functions. `self` and `workspace` are what its own functions returned. None may be NULL. */
typedef struct touchstone_backend {
  uint32_t abi_version;    /**< TOUCHSTONE_ABI_VERSION */
  uint32_t struct_size;    /**< sizeof(touchstone_backend) */
  const char* name;        /**< a word, by which it is chosen */
  const char* description; /**< one line, with library and version */
  touchstone_capabilities capabilities;

  /** A new instance without solids; NULL: no memory. */
  void* (*create)(void);
  /** Gives it back. */
  void (*destroy)(void* self);
  /**
   * Takes copies of the solids, in the place of those before. @param corners 24 doubles a solid [m], as in
   * touchstone_build(), always a convex hexahedron in that order.
   * @param error where to write why a solid cannot be taken, `error_size` bytes with the closing 0.
   * @return 0, or anything else where nothing was changed.
   */
  int (*build)(void* self, const double* corners, size_t solids, char* error, size_t error_size);
  /** A thread's scratch memory; NULL is allowed where there is none. */
  void* (*create_workspace)(const void* self);
  /** Gives it back. */
  void (*destroy_workspace)(void* workspace);
  /**
   * Answers a batch into the caller's slots; indices are good, poses may hold what is not finite. Threads as
   * capabilities.thread_safe says, each with a workspace of its own. What is no answer (a status that is none
   * or was not written, NaN, a point_count out of range) counts as TOUCHSTONE_FAILED.
   */
  void (*evaluate)(const void* self, void* workspace, const touchstone_input* input,
                   const touchstone_output* output);
} touchstone_backend;

/** Defined by the plug-in. */
#ifdef __GNUC__
__attribute__((visibility("default")))
#endif
extern const touchstone_backend touchstone_plugin;

#ifdef __cplusplus
}
#endif

#endif
