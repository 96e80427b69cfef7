#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "touchstone/contact_core/native/native.hpp"

namespace touchstone::proof {

/// `native`, its answers spoilt afterwards: what the checks must catch.
class LyingNarrowphase final : public Narrowphase {
 public:
  using Lie = std::function<void(const NarrowphaseInput&, const NarrowphaseOutput&)>;
  explicit LyingNarrowphase(Lie lie) : lie_(std::move(lie)) {}

  std::string_view name() const noexcept override { return "lying"; }
  const Capabilities& capabilities() const noexcept override { return native_->capabilities(); }
  void build(std::span<const Hexahedron> solids) override { native_->build(solids); }
  std::unique_ptr<Workspace> make_workspace() const override { return native_->make_workspace(); }
  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace& workspace) const noexcept override {
    native_->evaluate(input, output, workspace);
    lie_(input, output);
  }

 private:
  std::unique_ptr<Narrowphase> native_ = make_native();
  Lie lie_;
};

}  // namespace touchstone::proof
