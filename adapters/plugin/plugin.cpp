#include "touchstone/adapters/plugin/plugin.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cstdio>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "touchstone/adapters/c_interface/corners.hpp"
#include "touchstone/adapters/c_interface/layout.hpp"
#include "touchstone/adapters/c_interface/touchstone_plugin.h"
#include "touchstone/adapters/plugin/engine_name.hpp"
#include "touchstone/adapters/plugin/floating_point_mode.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/narrowphase/answer_check.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
#include "touchstone/contact_core/narrowphase/validate.hpp"

namespace touchstone {
namespace {

/// Calls into a library. What it throws ends here, and the thread's floating point is as before. Returns what
/// went wrong, a literal; nullptr where nothing did. A library that ends the thread (pthread_exit) ends the
/// process, as it would by going through this noexcept.
template <class Call>
const char* call_out(const Call& call) noexcept {
  const FloatingPointMode mode;
  const char* problem = nullptr;
  try {
    call();
  } catch (...) {
    problem = "it throws an exception";
  }
  mode.put_back();
  return problem;
}

/// A loaded library and what it exports; shared by all that call into it.
class Library {
 public:
  explicit Library(const std::filesystem::path& path) : path_(path.string()) {
    // glibc lets nothing through that static initialisers throw: the process ends.
    call_out([&] { handle_ = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL); });
    if (handle_ == nullptr) {
      const char* const why = dlerror();
      reject("plug-in " + path_, why == nullptr ? "cannot be loaded" : why);
    }
    backend_ = static_cast<const touchstone_backend*>(dlsym(handle_, "touchstone_plugin"));
    const std::string wrong = what_is_wrong();
    if (wrong.empty()) return;
    close();
    reject("plug-in " + path_, wrong);
  }
  ~Library() { close(); }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  const touchstone_backend& backend() const { return *backend_; }

 private:
  void close() const noexcept {
    call_out([&] { dlclose(handle_); });
  }

  std::string what_is_wrong() const {
    if (backend_ == nullptr) return "exports no touchstone_plugin";
    const touchstone_backend& b = *backend_;
    if (b.abi_version != TOUCHSTONE_ABI_VERSION)
      return "is made for version " + std::to_string(b.abi_version) + " of the interface, this is " +
             std::to_string(TOUCHSTONE_ABI_VERSION);
    if (b.struct_size < sizeof(touchstone_backend))
      return "its struct_size is " + std::to_string(b.struct_size) + ", must be " +
             std::to_string(sizeof(touchstone_backend));
    if (b.name == nullptr || !is_engine_name(b.name)) return kNoEngineName;
    if (const char* const wrong = broken_capabilities(c_interface::capabilities_of(b.capabilities)))
      return wrong;
    if (b.create == nullptr || b.destroy == nullptr || b.build == nullptr || b.create_workspace == nullptr ||
        b.destroy_workspace == nullptr || b.evaluate == nullptr)
      return "lacks a function";
    return "";
  }

  std::string path_;
  void* handle_ = nullptr;
  const touchstone_backend* backend_ = nullptr;
};

/// @throws InputError where there is a problem.
void refuse_throwing(const Library& library, const char* problem) {
  if (problem != nullptr) reject("plug-in " + std::string(library.backend().name), problem);
}

struct PluginWorkspace final : Narrowphase::Workspace {
  PluginWorkspace(std::shared_ptr<const Library> of, const void* self) : library(std::move(of)) {
    refuse_throwing(*library, call_out([&] { memory = library->backend().create_workspace(self); }));
  }
  ~PluginWorkspace() override {
    if (memory != nullptr) call_out([&] { library->backend().destroy_workspace(memory); });
  }
  PluginWorkspace(const PluginWorkspace&) = delete;
  PluginWorkspace& operator=(const PluginWorkspace&) = delete;

  std::shared_ptr<const Library> library;
  void* memory = nullptr;
};

class PluginNarrowphase final : public Narrowphase {
 public:
  explicit PluginNarrowphase(std::shared_ptr<const Library> library)
      : library_(std::move(library)), capabilities_(c_interface::capabilities_of(backend().capabilities)) {
    refuse_throwing(*library_, call_out([&] { self_ = backend().create(); }));
    if (self_ == nullptr) throw std::bad_alloc();
  }
  ~PluginNarrowphase() override {
    call_out([&] { backend().destroy(self_); });
  }
  PluginNarrowphase(const PluginNarrowphase&) = delete;
  PluginNarrowphase& operator=(const PluginNarrowphase&) = delete;

  std::string_view name() const noexcept override { return backend().name; }
  const Capabilities& capabilities() const noexcept override { return capabilities_; }

  void build(std::span<const Hexahedron> solids) override {
    refuse_rounded(solids, "plug-in " + std::string(name()));
    const std::vector<double> corners = c_interface::corners_of(solids);
    std::array<char, 512> error{};
    int refusal = 0;
    refuse_throwing(*library_, call_out([&] {
      refusal = backend().build(self_, corners.data(), solids.size(), error.data(), error.size());
    }));
    if (refusal != 0) {
      error.back() = '\0';
      reject("plug-in " + std::string(name()),
             error[0] == '\0' ? "refuses a solid" : engine_text(error.data()));
    }
    solid_count_ = solids.size();
  }

  std::unique_ptr<Workspace> make_workspace() const override {
    return std::make_unique<PluginWorkspace>(library_, self_);
  }

  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace& workspace) const noexcept override {
    assert(fits(input, output, solid_count_));
    constexpr auto kNotWritten = static_cast<PairStatus>(255);
    const std::size_t count = input.pairs.size();
    std::fill_n(output.status.begin(), count, kNotWritten);
    if (!output.geometry.empty()) std::fill_n(output.geometry.begin(), count, no_geometry());
    const touchstone_input asked = c_interface::c_input(input);
    const touchstone_output slots = c_interface::c_output(output);
    const char* const problem = call_out(
        [&] { backend().evaluate(self_, static_cast<PluginWorkspace&>(workspace).memory, &asked, &slots); });
    if (problem != nullptr) std::fill_n(output.status.begin(), count, kNotWritten);

    std::size_t first = 0;
    const char* what = nullptr;
    const std::size_t broken = settle_answers(input.query, count, output, first, what);
    if (problem != nullptr) what = problem;
    if (broken > 0 && !has_complained_.exchange(true))
      std::fprintf(stderr, "touchstone: plug-in %s, pair %zu of %zu: %s; counted as failed\n", backend().name,
                   first, count, what);
  }

 private:
  const touchstone_backend& backend() const noexcept { return library_->backend(); }

  std::shared_ptr<const Library> library_;
  Capabilities capabilities_;
  void* self_ = nullptr;
  std::size_t solid_count_ = 0;
  mutable std::atomic<bool> has_complained_ = false;
};

}  // namespace

std::string register_plugin(BackendRegistry& registry, const std::filesystem::path& library) {
  const auto loaded = std::make_shared<const Library>(library);
  const touchstone_backend& backend = loaded->backend();
  registry.add(BackendRegistry::NarrowphaseEntry{
      backend.name,
      engine_text(backend.description == nullptr ? "plug-in " + library.string() : backend.description),
      [loaded] { return std::make_unique<PluginNarrowphase>(loaded); },
      {}});
  return backend.name;
}

}  // namespace touchstone
