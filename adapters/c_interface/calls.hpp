#pragma once

#include <exception>
#include <initializer_list>
#include <new>
#include <utility>

#include "touchstone/adapters/c_interface/touchstone.h"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/registry.hpp"

// Shared by the functions of touchstone.h: errors become codes, names become backends.

namespace touchstone::c_interface {

/// Keeps the text for touchstone_error(), cut to its room. Returns the code.
touchstone_code fail(touchstone_code code, const char* text) noexcept;

/// A pointer that a caller gave, and its name in the header.
struct Argument {
  const void* pointer;
  const char* name;
};

/// @throws InputError naming an argument that is NULL.
inline void require(const void* pointer, const char* name) {
  if (pointer == nullptr) reject(name, "is NULL");
}

/// Calls `body`; what it throws becomes a code.
/// @param needed refused, the first that is NULL, before `body` is called.
template <class Body>
touchstone_code guarded(std::initializer_list<Argument> needed, Body&& body) noexcept {
  try {
    for (const Argument& each : needed) require(each.pointer, each.name);
    std::forward<Body>(body)();
    return TOUCHSTONE_OK;
  } catch (const InputError& error) {
    return fail(TOUCHSTONE_BAD_INPUT, error.what());
  } catch (const std::bad_alloc&) {
    return fail(TOUCHSTONE_NO_MEMORY, "not enough memory");
  } catch (const std::exception& error) {
    return fail(TOUCHSTONE_FAILURE, error.what());
  } catch (...) {
    return fail(TOUCHSTONE_FAILURE, "unknown exception");
  }
}

/// Contact_core's backends, and exact where it was built.
const BackendRegistry& registry();

}  // namespace touchstone::c_interface
