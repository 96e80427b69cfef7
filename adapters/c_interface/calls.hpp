#pragma once

#include <exception>
#include <new>
#include <utility>

#include "touchstone/adapters/c_interface/touchstone.h"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/registry.hpp"

// Shared by the functions of touchstone.h: errors become codes, names become backends.

namespace touchstone::c_interface {

/// Keeps the text for touchstone_error(), cut to its room. Returns the code.
touchstone_code fail(touchstone_code code, const char* text) noexcept;

/// Calls `body`; what it throws becomes a code.
template <class Body>
touchstone_code guarded(Body&& body) noexcept {
  try {
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

/// @throws InputError naming an argument that is NULL.
inline void require(const void* pointer, const char* name) {
  if (pointer == nullptr) reject(name, "is NULL");
}

/// Contact_core's backends, and exact where it was built.
const BackendRegistry& registry();

}  // namespace touchstone::c_interface
