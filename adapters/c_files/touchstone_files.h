#ifndef TOUCHSTONE_FILES_H
#define TOUCHSTONE_FILES_H

/**
 * @file
 * Scenes and robots from files, for C11: a component of its own (c_files), so that who reads no files links
 * no readers. Conventions, errors and versions are those of touchstone.h. Paths are as the system has them.
 */

#include "touchstone/adapters/c_interface/touchstone.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A value for a scene file's `parameters`, in the file's units. */
typedef struct touchstone_parameter {
  const char* name;
  double value;
} touchstone_parameter;

/** What a scene file says about its frames. */
typedef struct touchstone_scene_facts {
  double frame_rate; /**< [Hz] */
  double duration;   /**< [s] */
  double gap;        /**< that is kept [m] */
  uint64_t frames;   /**< with the one at time 0: touchstone_step_scene() comes to the end after frames - 1 */
} touchstone_scene_facts;

/**
 * A world with all that a scene file (YAML, adapters/scene_files/README.md) has: objects, groups, rules,
 * exemptions, latches and the gap. What is added, commanded and asked is as in any world.
 * @param backend as touchstone_create_world().
 * @param parameters `count` of them; they replace the file's own.
 * @return TOUCHSTONE_BAD_INPUT for what is no such file; the text names file, line and element.
 */
touchstone_code touchstone_load_scene(const char* backend, const char* path,
                                      const touchstone_parameter* parameters, size_t count,
                                      touchstone_world** out);
/** @return TOUCHSTONE_BAD_INPUT for a world that is no scene's, as the next two. */
touchstone_code touchstone_get_scene_facts(const touchstone_world* world, touchstone_scene_facts* out);
/** How many objects the file has. */
touchstone_code touchstone_get_scene_object_count(const touchstone_world* world, size_t* out);
/**
 * touchstone_frame() by the motions that the file prescribes: the next of its frames. What was stopped is
 * commanded to go from where it is to where it should be. Beyond the file's end that is where its last
 * motion ends. Objects that were removed are left out.
 */
touchstone_code touchstone_step_scene(touchstone_world* world, touchstone_report* out);
/** An object of the file by its place there, from 0; names are touchstone_find_object()'s. */
touchstone_code touchstone_get_scene_object(const touchstone_world* world, size_t index,
                                            touchstone_object* out);

/** How a robot's file is read. Zero bytes are the defaults. */
typedef struct touchstone_robot_options {
  const char* srdf; /**< a file of pairs that are not checked; NULL: none */
  const touchstone_mechanism_options* mechanism; /**< NULL: the defaults */
  int32_t exempt_reference_overlaps; /**< other than 0: so are links that overlap in the reference pose */
  int32_t free_mimic_joints;         /**< other than 0: joints that follow another one are joints of their own */
  int32_t sphere_facets; /**< 0: spheres and capsules are rounded solids, for `native` and `exact`; else as
                            RobotOptions */
  int32_t reserved;      /**< 0 */
} touchstone_robot_options;

/**
 * Adds the robot that a file describes: .urdf, and where this build reads them .sdf, and .xml or .mjcf. Each
 * mesh becomes one turned box that holds it (Python and C++ fit covers).
 * @param name unique in the world; NULL: the file's.
 * @param values joint values to begin with, `count` of them; none: the file's reference.
 * @return TOUCHSTONE_BAD_INPUT for what is no robot; the text names file and element.
 */
touchstone_code touchstone_add_robot(touchstone_world* world, const char* name, const char* path,
                                     const touchstone_robot_options* options, const touchstone_pose* X_WB,
                                     const double* values, size_t count, touchstone_mechanism* out);

#ifdef __cplusplus
}
#endif

#endif
