#pragma once

/// `function` where `built` (a constant expression) holds; elsewhere null, and no library is asked for it.
/// Lets a table of what a build may lack stand without #ifdef: declared always, linked where it is built.
#define TOUCHSTONE_IF_BUILT(built, function) \
  []() -> decltype(&(function)) {            \
    if constexpr (built) return &(function); \
    return nullptr;                          \
  }()
