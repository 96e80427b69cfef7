#include "touchstone/contact_core/narrowphase/checked.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <utility>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
#include "touchstone/contact_core/narrowphase/validate.hpp"

namespace touchstone {
namespace {

class Checked final : public Narrowphase {
 public:
  Checked(std::unique_ptr<Narrowphase> narrowphase, BrokenCallHandler handler)
      : narrowphase_(std::move(narrowphase)), handler_(std::move(handler)) {}

  std::string_view name() const noexcept override { return narrowphase_->name(); }
  const Capabilities& capabilities() const noexcept override { return narrowphase_->capabilities(); }
  void build(std::span<const Hexahedron> solids) override {
    narrowphase_->build(solids);
    solid_count_ = solids.size();
  }
  bool set_solids(SolidIndex first, std::span<const Hexahedron> solids) override {
    if (!narrowphase_->set_solids(first, solids)) return false;
    solid_count_ = std::max(solid_count_, first + solids.size());
    return true;
  }
  std::unique_ptr<Workspace> make_workspace() const override { return narrowphase_->make_workspace(); }

  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace& workspace) const noexcept override {
    try {
      validate(input, output, solid_count_);
    } catch (const std::exception& broken) {
      handler_(broken.what());
      fail_all(input, output);
      return;
    }
    narrowphase_->evaluate(input, output, workspace);
  }

 private:
  static void fail_all(const NarrowphaseInput& input, const NarrowphaseOutput& output) {
    const std::size_t count = input.pairs.size();
    std::fill_n(output.status.begin(), std::min(count, output.status.size()), PairStatus::failed);
    std::fill_n(output.geometry.begin(), std::min(count, output.geometry.size()), no_geometry());
  }

  std::unique_ptr<Narrowphase> narrowphase_;
  BrokenCallHandler handler_;
  std::size_t solid_count_ = 0;
};

}  // namespace

void abort_on_broken_call(std::string_view what) {
  std::fprintf(stderr, "touchstone: broken call of Narrowphase::evaluate(): %.*s\n",
               static_cast<int>(what.size()), what.data());
  std::abort();
}

std::unique_ptr<Narrowphase> checked(std::unique_ptr<Narrowphase> narrowphase, BrokenCallHandler handler) {
  if (!narrowphase) reject("checked()", "no narrowphase");
  if (!handler) reject("checked()", "no handler");
  return std::make_unique<Checked>(std::move(narrowphase), std::move(handler));
}

}  // namespace touchstone
