#pragma once
// A user's file of that name.
enum class Pose { sitting, standing };
#define TOUCHSTONE_STRANGERS_POSE
