#pragma once
// A user's file of that name.
struct RigidBody {
  int wheels = 4;
};
