#ifndef TOUCHSTONE_DYNAMICS_H
#define TOUCHSTONE_DYNAMICS_H

/**
 * @file
 * Scenes with dynamics for C11: a component of its own (c_dynamics), so that who has no forces links no
 * physics. Bodies, arms with torque limits, friction, latches and actions are those of the scene file
 * (`dynamics`, adapters/scene_files/README.md); our own engine steps them. Conventions, errors and versions
 * are those of touchstone.h. SI units, world frame. One thread at a time has a simulation.
 */

#include "touchstone/adapters/c_files/touchstone_files.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A run of a scene file's dynamics. */
typedef struct touchstone_simulation touchstone_simulation;
/** All that a run has come to; good for its own simulation alone. */
typedef struct touchstone_saved_run touchstone_saved_run;

/** What a scene file says about its run. */
typedef struct touchstone_simulation_facts {
  double step;    /**< [s] */
  uint64_t steps; /**< to the file's end; they may go on beyond it */
  size_t objects; /**< numbered from 0 in the file's order; links of arms are among them */
} touchstone_simulation_facts;

/** How a step went. */
typedef struct touchstone_step {
  uint64_t steps;        /**< taken since the start */
  double time;           /**< [s] */
  size_t contacts;       /**< points */
  uint32_t undecided;    /**< pairs that the check left open */
  uint32_t failed;       /**< pairs that it could not answer */
  uint32_t unconverged;  /**< contact problems whose work ended before the laws held */
  uint32_t reserved;     /**< 0 */
  double worst_residual; /**< of these [m/s] */
} touchstone_step;

/** Where an object is and how it moves. */
typedef struct touchstone_object_state {
  touchstone_pose X_WO;
  double v_W[3]; /**< of the centre of mass of all that moves with it [m/s]; NaN: no free body, or fixed */
  double w_W[3]; /**< [rad/s]; NaN likewise */
} touchstone_object_state;

/** A contact point of the last step, as it was at the step's start. */
typedef struct touchstone_contact {
  size_t object_a; /**< their numbers */
  size_t object_b;
  double p_W[3];     /**< half-way between the surfaces [m] */
  double n_AB_W[3];  /**< unit, from A to B */
  double separation; /**< [m] */
  double force_W[3]; /**< on B, mean over the step, impacts included [N] */
} touchstone_contact;

/** A joint's state. */
typedef struct touchstone_joint_state {
  double value;  /**< [rad] or [m] */
  double rate;   /**< [rad/s] or [m/s] */
  double torque; /**< of its drive, mean over the last step [N m] or [N] */
} touchstone_joint_state;

/**
 * A scene file's dynamics at their start.
 * @param check the narrowphase that finds contacts, "native" for one; it has manifolds.
 * @param parameters `count` of them; they replace the file's own.
 * @return TOUCHSTONE_BAD_INPUT for what is no such file, or has no `dynamics`; the text names file, line and
 * element.
 */
touchstone_code touchstone_load_simulation(const char* check, const char* path,
                                           const touchstone_parameter* parameters, size_t count,
                                           touchstone_simulation** out);
/** NULL is allowed. */
void touchstone_destroy_simulation(touchstone_simulation* simulation);
/** Step and length of the run, and how many objects it has. */
touchstone_code touchstone_get_simulation_facts(const touchstone_simulation* simulation,
                                                touchstone_simulation_facts* out);
/** An object's number by its name. @return TOUCHSTONE_BAD_INPUT: there is none. */
touchstone_code touchstone_find_simulated_object(const touchstone_simulation* simulation, const char* name,
                                                 size_t* out);

/**
 * Takes the next step, with the file's actions that are due. Does not allocate, once warm, up to 128 contact
 * points.
 * @return TOUCHSTONE_FAILURE naming what failed: time does not go on; actions due before the failure are
 * carried out, and pushes stay for the next step.
 */
touchstone_code touchstone_step_simulation(touchstone_simulation* simulation, touchstone_step* out);
/** Of the first `count` objects. @return TOUCHSTONE_BAD_INPUT for more than there are. */
touchstone_code touchstone_get_object_states(const touchstone_simulation* simulation,
                                             touchstone_object_state* states, size_t count);
/** Of the last step; valid until the next. */
touchstone_code touchstone_get_contacts(touchstone_simulation* simulation, const touchstone_contact** out,
                                        size_t* count);
/** A joint by its name, `arm.elbow`, or that of a joint between bodies. */
touchstone_code touchstone_get_joint_state(const touchstone_simulation* simulation, const char* joint,
                                           touchstone_joint_state* out);
/**
 * Pushes an object, with all that moves with it, over the next step: a force at p_W, in addition to gravity,
 * drives and contacts. Several add up.
 * @param force_W [N] @param p_W [m] @param moment_W [N m]; NULL: none
 * @return TOUCHSTONE_BAD_INPUT: no such object, one that is fixed or follows a motion, no figures.
 */
touchstone_code touchstone_push_object(touchstone_simulation* simulation, size_t object,
                                       const double force_W[3], const double p_W[3],
                                       const double moment_W[3]);

/** Saves the run between steps. */
touchstone_code touchstone_save_run(const touchstone_simulation* simulation, touchstone_saved_run** out);
/**
 * Back to then, as often as wanted: the steps from there are the same to the bit. Pushes for the next step
 * are forgotten.
 */
touchstone_code touchstone_restore_run(touchstone_simulation* simulation, const touchstone_saved_run* saved);
/** Back to the start, as just loaded. */
touchstone_code touchstone_reset_run(touchstone_simulation* simulation);
/** NULL is allowed; before or after its simulation. */
void touchstone_destroy_saved_run(touchstone_saved_run* saved);

#ifdef __cplusplus
}
#endif

#endif
