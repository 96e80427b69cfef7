#pragma once
// A user's file of that name.
inline int random_number() { return 4; }
