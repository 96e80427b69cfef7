#pragma once
// A user's file of that name.
inline int register_exact(int x) { return 2 * x; }
