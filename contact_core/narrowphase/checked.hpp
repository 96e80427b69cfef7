#pragma once

#include <functional>
#include <memory>
#include <string_view>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone {

/// Gets what validate() found broken: one line, valid during the call. May be called from several threads
/// at once. Must not throw: evaluate() is noexcept. When it returns, the call is not passed on, and the
/// status of every pair that has a slot is `failed`, without geometry.
using BrokenCallHandler = std::function<void(std::string_view what)>;

/// Prints the backend's call and what is broken to stderr, and aborts.
void abort_on_broken_call(std::string_view what);

/// Returns a narrowphase that validates every call (validate.hpp) and passes it on to `narrowphase`: name,
/// capabilities, workspaces and answers are that one's, to the bit. It costs a pass over the pairs and their
/// poses. For development, and for callers that cannot vouch for their input.
/// @throws InputError where `narrowphase` or `handler` is empty.
std::unique_ptr<Narrowphase> checked(std::unique_ptr<Narrowphase> narrowphase,
                                     BrokenCallHandler handler = abort_on_broken_call);

}  // namespace touchstone
