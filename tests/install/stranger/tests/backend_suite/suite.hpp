#pragma once
// A user's file of that name.
namespace suite {
inline int size() { return 3; }
}  // namespace suite
