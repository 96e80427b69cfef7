#ifndef TOUCHSTONE_H
#define TOUCHSTONE_H

/**
 * @file
 * Touchstone's narrowphases for C11 and whatever calls C. Conventions are those of
 * contact_core/narrowphase/narrowphase.hpp:
 *  - SI units, doubles. Solids are closed sets: touching is contact (overlapping, separation 0).
 *  - n_AB_W is a unit vector from A to B, in world axes. separation > 0 apart, < 0 overlapping.
 *  - p_B_W = p_A_W + separation * n_AB_W.
 *  - Results come in the order of the pairs; result i depends on pair i alone.
 *
 * Errors: a call that can fail returns a touchstone_code and, where that is not TOUCHSTONE_OK, has changed
 * nothing; touchstone_error() has the text. Nothing throws, nothing ends the process.
 *
 * Threads, of pairs: touchstone_evaluate() may be called from several at once on one narrowphase, each with a
 * workspace of its own; the other calls on a narrowphase not while it is in use.
 *
 * Versions: what is declared here stays as it is within one TOUCHSTONE_ABI_VERSION; functions and structs may
 * be added.
 */

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The version of this header's structs and functions. @see touchstone_abi_version() */
#define TOUCHSTONE_ABI_VERSION 1u
/** Most contact points of one pair. */
#define TOUCHSTONE_MAX_POINTS 8

/** The outcome of a call. */
typedef int32_t touchstone_code;
/** Values of touchstone_code. */
enum {
  TOUCHSTONE_OK = 0,
  TOUCHSTONE_BAD_INPUT = 1, /**< the caller's argument; the text names it */
  TOUCHSTONE_NO_MEMORY = 2,
  TOUCHSTONE_FAILURE = 3 /**< anything else */
};

/** An answer about one pair, one byte. */
typedef uint8_t touchstone_status;
/** Values of touchstone_status. */
enum {
  TOUCHSTONE_SEPARATED = 0,   /**< apart by more than the declared resolution */
  TOUCHSTONE_OVERLAPPING = 1, /**< touching or penetrating */
  TOUCHSTONE_UNDECIDED = 2,   /**< closer to touching than the declared resolution; carries geometry */
  TOUCHSTONE_FAILED = 3,      /**< not converged, or a pose is not finite; carries nothing */
  TOUCHSTONE_UNSUPPORTED = 4  /**< the backend does not answer this query; carries nothing */
};

/** Values of touchstone_query::kind; each includes those before it. */
enum {
  TOUCHSTONE_OVERLAP = 0,  /**< status only */
  TOUCHSTONE_DISTANCE = 1, /**< signed distance, normal, witness points */
  TOUCHSTONE_MANIFOLD = 2  /**< the same and up to max_points contact points */
};

/** Two different solids by their index in touchstone_build(). */
typedef struct touchstone_pair {
  uint32_t a;
  uint32_t b;
} touchstone_pair;

/** The pose X_WS of a solid S in the world: p_W = R p_S + p. */
typedef struct touchstone_pose {
  double R[9]; /**< column by column: R[0..2] is S's x axis in the world */
  double p[3]; /**< S's origin in the world [m] */
} touchstone_pose;

/** The question. */
typedef struct touchstone_query {
  int32_t kind;
  int32_t max_points;    /**< manifold: slots a pair, 1 to TOUCHSTONE_MAX_POINTS */
  double max_separation; /**< pairs further apart [m] are separated with separation +inf, NaN elsewhere */
  double max_point_separation; /**< points further apart [m], and than the pair, are not in a manifold */
} touchstone_query;

/** A pair's answer to a distance or manifold query; NaN where the status carries nothing. */
typedef struct touchstone_geometry {
  double separation; /**< signed [m] */
  double n_AB_W[3];  /**< unit, from A to B */
  double p_A_W[3];   /**< witness point on A [m] */
  double p_B_W[3];   /**< witness point on B [m] */
  int32_t point_count;
  int32_t reserved;
} touchstone_geometry;

/** One point of a manifold, on both surfaces. */
typedef struct touchstone_point {
  double p_A_W[3];
  double p_B_W[3];
  double separation;   /**< along the pair's n_AB_W [m] */
  uint32_t feature_id; /**< stable while the contact keeps its shape; 0: unknown */
  uint32_t reserved;
} touchstone_point;

/** A backend's queries and resolution; flags are 0 or 1. */
typedef struct touchstone_capabilities {
  uint8_t distance;         /**< of pairs apart */
  uint8_t penetration;      /**< of pairs that overlap */
  uint8_t manifold;         /**< contact points */
  uint8_t overlap_complete; /**< 0: missed contacts are expected */
  uint8_t deterministic;    /**< same bits for the same pair */
  uint8_t thread_safe;      /**< several threads at once */
  uint8_t reserved[2];
  int32_t scalar_bits;        /**< of its own arithmetic: 64, 32 */
  int32_t reserved_word;      /**< 0 */
  double absolute_resolution; /**< separations are within absolute + relative * scale [m] of the truth, */
  double relative_resolution; /**< scale the larger of |world coordinate| and size [m] */
  double depth_resolution;    /**< further, per metre of depth; infinite: nothing is claimed */
} touchstone_capabilities;

/** A fine check by name; see touchstone_create(). */
typedef struct touchstone_narrowphase touchstone_narrowphase;
/** A thread's scratch memory for one narrowphase. */
typedef struct touchstone_workspace touchstone_workspace;

/** A batch of pairs, all asked the same; the arrays are the caller's. */
typedef struct touchstone_input {
  const touchstone_pair* pairs;
  size_t pair_count;
  const touchstone_pose* poses; /**< one a solid, in the order of touchstone_build() */
  size_t pose_count;            /**< at least as many as solids */
  touchstone_query query;
} touchstone_input;

/** The caller's slots: pair i writes status[i], geometry[i] and points[i * max_points ...) only. */
typedef struct touchstone_output {
  touchstone_status* status;     /**< pair_count */
  touchstone_geometry* geometry; /**< pair_count; may be NULL for overlap */
  touchstone_point* points;      /**< pair_count * max_points; may be NULL unless manifold */
} touchstone_output;

/** TOUCHSTONE_ABI_VERSION of the library; another one than the header's: do not call on. */
uint32_t touchstone_abi_version(void);
/** The library's own version, "0.2.0". */
const char* touchstone_version(void);
/** Why this thread's last call failed: one line; "" before the first. Valid until the next that fails. */
const char* touchstone_error(void);

/** How many backends there are. */
size_t touchstone_backend_count(void);
/** The name of a backend; NULL from touchstone_backend_count() on. */
const char* touchstone_backend_name(size_t index);

/** Makes a narrowphase by its backend's name, "native" for one. It has no solids yet. */
touchstone_code touchstone_create(const char* backend, touchstone_narrowphase** out);
/** After its workspaces. NULL is allowed. */
void touchstone_destroy(touchstone_narrowphase* narrowphase);
/** As of the last touchstone_build(). */
touchstone_code touchstone_get_capabilities(const touchstone_narrowphase* narrowphase,
                                            touchstone_capabilities* out);
/**
 * Takes copies of the solids, in the place of those before.
 * @param corners 24 doubles a solid [m], in its own frame: x, y, z of corner 0, of corner 1 ... Corner i has
 * bits (x y z) = (i>>2 & 1, i>>1 & 1, i & 1): 0 is (-,-,-), 1 is (-,-,+), 7 is (+,+,+). Other orders of a
 * convex hexahedron's corners are understood. Corners that are exactly (+-hx, +-hy, +-hz) are a box.
 * @return TOUCHSTONE_BAD_INPUT for what is no convex hexahedron; the text names the solid and the face.
 */
touchstone_code touchstone_build(touchstone_narrowphase* narrowphase, const double* corners, size_t solids);
/** A workspace for one thread. Stays good when its narrowphase is built again. */
touchstone_code touchstone_create_workspace(const touchstone_narrowphase* narrowphase,
                                            touchstone_workspace** out);
/** NULL is allowed. */
void touchstone_destroy_workspace(touchstone_workspace* workspace);
/**
 * Answers a batch. Indices, counts and the query are checked, before anything is written; of poses only that
 * they are finite (a pair with another one is TOUCHSTONE_FAILED): that R is a rotation is the caller's care.
 * Does not allocate after the first call with a workspace where it returns TOUCHSTONE_OK.
 */
touchstone_code touchstone_evaluate(const touchstone_narrowphase* narrowphase,
                                    touchstone_workspace* workspace, const touchstone_input* input,
                                    const touchstone_output* output);

/** A pose from a 4 x 4 matrix, row by row. @return TOUCHSTONE_BAD_INPUT where it is no rigid transform. */
touchstone_code touchstone_pose_from_matrix(const double matrix[16], touchstone_pose* out);
/** A pose from a position [m] and a quaternion (w, x, y, z), of any length but 0. */
touchstone_code touchstone_pose_from_quaternion(const double position[3], const double quaternion[4],
                                                touchstone_pose* out);

/**
 * A contact world (contact_core/world/contact_world.hpp): objects that are commanded frame by frame and move
 * only as far as no pair gets closer than the gap. One thread owns a world; touchstone_select() alone may be
 * called from others. Set-up may allocate; touchstone_frame() does not, once warm.
 */
typedef struct touchstone_world touchstone_world;
/** Names an object of a world for as long as it lives; never reused. */
typedef uint64_t touchstone_object;
/** In place of an object: none. */
#define TOUCHSTONE_NO_OBJECT UINT64_MAX

/** What stops a pair's movers. */
enum {
  TOUCHSTONE_CUE = 0,     /**< nothing: entry and exit are reported */
  TOUCHSTONE_HOLD = 1,    /**< the step is not executed; what holds where no policy was set */
  TOUCHSTONE_ADVANCE = 2, /**< up to the contact */
  TOUCHSTONE_SLIDE = 3    /**< up to it, then along it */
};

/** Values of touchstone_event::kind, as EventKind of contact_world.hpp. */
enum {
  TOUCHSTONE_NEAR = 0,
  TOUCHSTONE_BEGAN = 1,
  TOUCHSTONE_PERSISTS = 2,
  TOUCHSTONE_ENDED = 3,
  TOUCHSTONE_PENETRATING_AT_START = 4,
  TOUCHSTONE_BLOCKED = 5,
  TOUCHSTONE_REFUSED = 6,
  TOUCHSTONE_AT_LIMIT = 7
};

/** An object to go to a pose over a frame, on the shorter way round. */
typedef struct touchstone_command {
  touchstone_object object;
  touchstone_pose X_WO;
} touchstone_command;

/** An event of a frame: of a pair of solids, or of a command (b: TOUCHSTONE_NO_OBJECT). */
typedef struct touchstone_event {
  touchstone_object a, b;
  uint32_t solid_a, solid_b; /**< within their objects, in the order of touchstone_add_object() */
  int32_t kind;
  uint32_t part;                /**< 0: the commanded paths; then the sub-steps of slides */
  double s;                     /**< within the part, 0 to 1 */
  touchstone_geometry geometry; /**< then; NaN where there is none */
} touchstone_event;

/** How a frame went. */
typedef struct touchstone_report {
  uint64_t frame;
  const touchstone_event* events; /**< by pair; valid until the world's next frame */
  size_t event_count;
  uint64_t queries;         /**< narrowphase calls */
  uint32_t blocked_movers;  /**< stopped on their commanded paths */
  uint32_t candidate_pairs; /**< looked at */
  uint8_t is_proven;        /**< 0: the backend judges poses only, and what it does not see is let through */
  uint8_t reserved[7];
} touchstone_report;

/** Makes an empty world. @param gap kept between objects [m], finite, > 0; 0: the default, 1e-7. */
touchstone_code touchstone_create_world(const char* backend, double gap, touchstone_world** out);
/** NULL is allowed. */
void touchstone_destroy_world(touchstone_world* world);
/**
 * Adds a rigid object.
 * @param name unique in the world.
 * @param corners of its solids, as touchstone_build(), in the object's frame.
 * @param is_static other than 0: it never moves.
 */
touchstone_code touchstone_add_object(touchstone_world* world, const char* name, const double* corners,
                                      size_t solids, const touchstone_pose* X_WO, int32_t is_static,
                                      touchstone_object* out);
/** Takes it from the world. */
touchstone_code touchstone_remove_object(touchstone_world* world, touchstone_object object);
/**
 * The rule of a pair (before any other), or of all pairs: a and b TOUCHSTONE_NO_OBJECT.
 * @param warn_distance events TOUCHSTONE_NEAR come within this [m]; finite, >= 0.
 */
touchstone_code touchstone_set_policy(touchstone_world* world, touchstone_object a, touchstone_object b,
                                      int32_t policy, double warn_distance);
/** `carried` moves with `carrier` from now on, as they stand; the two are not checked against each other. */
touchstone_code touchstone_latch(touchstone_world* world, touchstone_object carrier,
                                 touchstone_object carried);
/** Ends that. */
touchstone_code touchstone_unlatch(touchstone_world* world, touchstone_object carried);
/**
 * Switches checks from the next frame on, from any thread: of everything (a and b TOUCHSTONE_NO_OBJECT), of
 * an object (b that), of a pair. @param on 0: off.
 */
touchstone_code touchstone_select(touchstone_world* world, touchstone_object a, touchstone_object b,
                                  int32_t on);
/** Takes up all set-up so far, which a frame would do else. */
touchstone_code touchstone_prepare(touchstone_world* world);
/**
 * Moves what is commanded as far as the rules allow. A pose that is none is reported (TOUCHSTONE_REFUSED) and
 * its object stays. @return TOUCHSTONE_BAD_INPUT for an object that is none: nothing moved.
 */
touchstone_code touchstone_frame(touchstone_world* world, const touchstone_command* commands, size_t count,
                                 touchstone_report* out);
/** X_WO of objects, as the last frame left them. @param poses `count` of them. */
touchstone_code touchstone_get_poses(const touchstone_world* world, const touchstone_object* objects,
                                     size_t count, touchstone_pose* poses);

/** touchstone_add_object() of one that is in groups. @param groups `group_count` names; 64 groups a world. */
touchstone_code touchstone_add_object_in_groups(touchstone_world* world, const char* name,
                                                const double* corners, size_t solids,
                                                const touchstone_pose* X_WO, int32_t is_static,
                                                const char* const* groups, size_t group_count,
                                                touchstone_object* out);
/** The rule of all pairs with one object in each group (one group twice: within it); a pair's own comes
 * before it. */
touchstone_code touchstone_set_group_policy(touchstone_world* world, const char* first, const char* second,
                                            int32_t policy, double warn_distance);
/** touchstone_select() of every object in a group. */
touchstone_code touchstone_select_group(touchstone_world* world, const char* group, int32_t on);

/** Work that a mover's slide may take unless set otherwise. */
#define TOUCHSTONE_MOVER_WORK 16384u

/** The budget of a frame's slides (SlideBudget of contact_world.hpp); commanded paths do not count. */
typedef struct touchstone_slide_budget {
  uint64_t pairs;      /**< near pairs, of all slides; UINT64_MAX: no limit. The same on every machine */
  double seconds;      /**< by the clock [s], >= 0; infinite: no limit. The cut differs from run to run */
  uint64_t mover_work; /**< of each mover by itself: rows, steps and looks, 0.2 to 1 us each */
} touchstone_slide_budget;

/** For all frames from now on. @param budget NULL: no limit but TOUCHSTONE_MOVER_WORK, as before the first
 * call. */
touchstone_code touchstone_set_slide_budget(touchstone_world* world, const touchstone_slide_budget* budget);
/** The one in force. */
touchstone_code touchstone_get_slide_budget(const touchstone_world* world, touchstone_slide_budget* out);
/** Movers whose slides the budget ended in the last frame; valid until the next. Where they stopped is safe.
 */
touchstone_code touchstone_get_cut_off(const touchstone_world* world, const touchstone_object** out,
                                       size_t* count);

/** How stiffly a hand holds an object (HandStiffness of contact_world.hpp): springs at a tool frame T of the
 * object. */
typedef struct touchstone_hand {
  touchstone_pose X_OT;  /**< T in the object; read where has_tool is not 0 */
  int32_t has_tool;      /**< 0: T is at the centre of mass of all that moves, along the object's axes */
  int32_t reserved;      /**< 0 */
  double translation[3]; /**< along T's axes [N/m]; > 0, within a factor of 1e6 */
  double turning[3];     /**< about T's axes [N m/rad]; as these, and 1e-6 to 1e6 m2 of them */
} touchstone_hand;

/** A hand's forces at a frame's end (HandFeel of contact_world.hpp). */
typedef struct touchstone_feel {
  touchstone_object object;
  double p_W[3];        /**< T's origin [m] */
  double lag_W[3];      /**< from there to where the command has it [m] */
  double turn_lag_W[3]; /**< axis times angle [rad] */
  double force_W[3];    /**< of the contacts [N] */
  double moment_W[3];   /**< about p_W [N m] */
} touchstone_feel;

/**
 * How stiffly the object is held where it is commanded; it decides how slides yield.
 * @param object TOUCHSTONE_NO_OBJECT: of all that were given none of their own, without a tool frame.
 * @param hand NULL: the metric of its mass instead, and 1 N/m to scale forces.
 */
touchstone_code touchstone_set_hand(touchstone_world* world, touchstone_object object,
                                    const touchstone_hand* hand);
/** Of every object that slid in the last frame or was commanded to, a mechanism with a hand by its first
 * link; valid until the next. */
touchstone_code touchstone_get_feels(const touchstone_world* world, const touchstone_feel** out,
                                     size_t* count);

/** Names a mechanism of a world for as long as it lives; never reused. */
typedef uint64_t touchstone_mechanism;

/** Values of touchstone_joint::kind. */
enum {
  TOUCHSTONE_FIXED = 0,
  TOUCHSTONE_REVOLUTE = 1, /**< turns about its axis [rad] */
  TOUCHSTONE_PRISMATIC = 2 /**< shifts along it [m] */
};

/** A rigid part of a mechanism. */
typedef struct touchstone_link {
  const char* name;
  const double* corners; /**< of its solids in its frame, as touchstone_build(); NULL where there are none */
  size_t solids;
} touchstone_link;

/** At value q the child stands in the parent at X_PJ J(q): J turns about axis_J or shifts along it by q. */
typedef struct touchstone_joint {
  const char* name;
  const char* parent; /**< names of links */
  const char* child;
  int32_t kind;
  int32_t reserved; /**< 0 */
  touchstone_pose X_PJ;
  double axis_J[3]; /**< unit; not read of a fixed one */
  double lower;     /**< [rad] or [m]; infinite: no limit */
  double upper;
} touchstone_joint;

/** What a mechanism is made from (MechanismDescription of mechanism.hpp): a tree of links. */
typedef struct touchstone_mechanism_description {
  const char* name; /**< unique in the world; its links are objects `name.link` */
  const touchstone_link* links;
  size_t link_count;
  const touchstone_joint* joints;
  size_t joint_count;
  const char* base; /**< the link that is held; NULL: the first */
} touchstone_mechanism_description;

/** Joint values at a frame's end, one a joint that moves, in the order of the description; all reached
 * evenly. */
typedef struct touchstone_joint_command {
  touchstone_mechanism mechanism;
  const double* values;
  size_t count;
} touchstone_joint_command;

/** How stiffly a hand holds a mechanism: springs at a tool frame T of a link (ArmHandStiffness of
 * contact_world.hpp). */
typedef struct touchstone_arm_hand {
  const char* link; /**< some joint moves it */
  touchstone_pose X_LT;
  double translation[3]; /**< as touchstone_hand */
  double turning[3];
  const double*
      joints; /**< springs at the joints' commanded values, joint_count; NULL: a hundredth of the least k */
  size_t joint_count;
} touchstone_arm_hand;

/**
 * Adds a mechanism: all of its links are one mover, stopped together.
 * @param X_WB of its base, which stands still.
 * @param values joint values to begin with, `count` of them; none (count 0): all 0.
 */
touchstone_code touchstone_add_mechanism(touchstone_world* world,
                                         const touchstone_mechanism_description* description,
                                         const touchstone_pose* X_WB, const double* values, size_t count,
                                         touchstone_mechanism* out);
/** The same of a bundled arm: model "ssrms", "ssrms_on_transporter", "spdm", "spdm_arm"; NULL values: its
 * reference. */
touchstone_code touchstone_add_arm(touchstone_world* world, const char* name, const char* model,
                                   const touchstone_pose* X_WB, const double* values, size_t count,
                                   touchstone_mechanism* out);
/** Takes it from the world. @return TOUCHSTONE_BAD_INPUT where a link carries an object. */
touchstone_code touchstone_remove_mechanism(touchstone_world* world, touchstone_mechanism mechanism);
/** The object that a link with solids is: for policies, latches, selection, events and poses. */
touchstone_code touchstone_get_link(const touchstone_world* world, touchstone_mechanism mechanism,
                                    const char* link, touchstone_object* out);
/** Actual joint values; valid until the mechanism is removed. */
touchstone_code touchstone_get_joints(const touchstone_world* world, touchstone_mechanism mechanism,
                                      const double** values, size_t* count);
/** As touchstone_set_hand(). NULL: all joint values weigh alike. */
touchstone_code touchstone_set_arm_hand(touchstone_world* world, touchstone_mechanism mechanism,
                                        const touchstone_arm_hand* hand);
/**
 * touchstone_frame() with mechanisms. Values beyond limits are taken as these (TOUCHSTONE_AT_LIMIT); a wrong
 * number, or one that is not finite, is reported (TOUCHSTONE_REFUSED) and the mechanism stays.
 */
touchstone_code touchstone_frame_with_joints(touchstone_world* world, const touchstone_command* commands,
                                             size_t count, const touchstone_joint_command* joints,
                                             size_t joint_count, touchstone_report* out);

/** A pair that is not checked: of objects, or of a solid of each. */
typedef struct touchstone_exemption {
  touchstone_object a, b;
  const char* solid_a; /**< its name: of solids from corners their number in decimal; NULL: all of the object */
  const char* solid_b;
} touchstone_exemption;
/** Until touchstone_unexempt(), or an object is removed. */
touchstone_code touchstone_exempt(touchstone_world* world, const touchstone_exemption* pair);
/** Takes it back. @return TOUCHSTONE_BAD_INPUT where the pair is not exempt. */
touchstone_code touchstone_unexempt(touchstone_world* world, const touchstone_exemption* pair);
/** The object of that name, a mechanism's link as `mechanism.link`. @return TOUCHSTONE_BAD_INPUT: there is
 * none. */
touchstone_code touchstone_find_object(const touchstone_world* world, const char* name,
                                       touchstone_object* out);

/** Two links that are not checked against each other, besides those that a joint joins. */
typedef struct touchstone_link_pair {
  const char* first; /**< a link, or `link/solid`: the solid's number in decimal */
  const char* second;
} touchstone_link_pair;

/** What else a mechanism is given. Zero bytes are the defaults. */
typedef struct touchstone_mechanism_options {
  const touchstone_link_pair* exempt;
  size_t exempt_count;
  const char* const* groups; /**< of every link */
  size_t group_count;
  const double* weights; /**< slides keep the sum of w dq^2 least: one a joint that moves, > 0; NULL: all 1 */
  size_t weight_count;
} touchstone_mechanism_options;
/** touchstone_add_mechanism() with options. @param options NULL: the defaults. */
touchstone_code touchstone_add_mechanism_with(touchstone_world* world,
                                              const touchstone_mechanism_description* description,
                                              const touchstone_mechanism_options* options,
                                              const touchstone_pose* X_WB, const double* values, size_t count,
                                              touchstone_mechanism* out);

/**
 * touchstone_build() of solids that may be rounded: every point within a radius of the corners' hull.
 * @param radii one a solid [m], finite, 0: not rounded; NULL: none is. Above 0, the corners may be those of a
 * box that is flat, exactly (+-hx, +-hy, +-hz) with h >= 0: a plate, a capsule with one side, a sphere with
 * none.
 * @return TOUCHSTONE_BAD_INPUT also where the backend takes none that are rounded ("edge_face").
 */
touchstone_code touchstone_build_rounded(touchstone_narrowphase* narrowphase, const double* corners,
                                         const double* radii, size_t solids);
/** touchstone_add_object_in_groups() of solids with radii, as touchstone_build_rounded(). */
touchstone_code touchstone_add_rounded_object(touchstone_world* world, const char* name,
                                              const double* corners, const double* radii, size_t solids,
                                              const touchstone_pose* X_WO, int32_t is_static,
                                              const char* const* groups, size_t group_count,
                                              touchstone_object* out);
/** touchstone_add_mechanism_with() of links with radii. @param radii one list a link, of its solids as
 * touchstone_build_rounded(); NULL: none is rounded, of all links or in a link's place. */
touchstone_code touchstone_add_rounded_mechanism(touchstone_world* world,
                                                 const touchstone_mechanism_description* description,
                                                 const double* const* radii,
                                                 const touchstone_mechanism_options* options,
                                                 const touchstone_pose* X_WB, const double* values,
                                                 size_t count, touchstone_mechanism* out);

#ifdef __cplusplus
}
#endif

#endif
