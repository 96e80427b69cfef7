#include "touchstone/examples/program/terminal/machine.hpp"

#include <fmt/core.h>
#include <gnu/libc-version.h>
#include <stdlib.h>
#include <sys/utsname.h>

#include <Eigen/Core>
#include <fstream>
#include <thread>

#include "touchstone/contact_core/native/simd/kernels.hpp"
#include "touchstone/examples/program/terminal/date.hpp"

namespace touchstone::program {
namespace {

std::string cpu_model() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name") && line.find(':') + 2 < line.size())
      return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

std::string compiler() {
#if defined(__clang__)
  return "clang " __clang_version__;
#else
  return "g++ " __VERSION__;
#endif
}

}  // namespace

std::string touchstone_version() { return TOUCHSTONE_VERSION; }

Machine describe_machine() {
  Machine machine;
  machine.cpu = cpu_model();
  machine.instruction_set = native::kernels().isa;
  machine.hardware_threads = std::thread::hardware_concurrency();
  utsname system{};
  if (uname(&system) == 0) {
    // Text after the version is the distributor's or the host's own.
    const std::string release = system.release;
    machine.system = std::string(system.sysname) + " " +
                     release.substr(0, release.find_first_not_of("0123456789.")) + " " + system.machine;
  }
  machine.compiler = compiler();
  machine.build_type = TOUCHSTONE_BUILD_TYPE;
  machine.flags = TOUCHSTONE_BUILD_FLAGS;
  machine.version = touchstone_version();
  machine.libraries = {
      {"Eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
      {"C library", std::string("glibc ") + gnu_get_libc_version()},
#ifdef __GLIBCXX__
      {"C++ library", fmt::format("libstdc++ {}", _GLIBCXX_RELEASE)},
#endif
  };
  return machine;
}

std::string page_head(const std::string& title, const std::string& command) {
  const Machine machine = describe_machine();
  double load = 0.0;
  const bool has_load = getloadavg(&load, 1) == 1;
  return fmt::format(
      "# {}\n\nTouchstone {}; {} ({}), {} hardware threads, {}; {}, {}; {}{}.\nWritten by `{}`.\n\n", title,
      machine.version, machine.cpu, machine.instruction_set, machine.hardware_threads, machine.system,
      machine.compiler, machine.build_type, today(), has_load ? fmt::format(", load {:.1f}", load) : "",
      command);
}

}  // namespace touchstone::program
