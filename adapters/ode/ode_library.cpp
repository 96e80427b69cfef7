#include "touchstone/adapters/ode/ode_library.hpp"

#include <mutex>

namespace touchstone::ode {
namespace {

std::mutex& library_mutex() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace

LibraryUse::LibraryUse() {
  const std::scoped_lock lock(library_mutex());
  dInitODE2(0);
}

LibraryUse::~LibraryUse() {
  const std::scoped_lock lock(library_mutex());
  dCloseODE();
}

}  // namespace touchstone::ode
