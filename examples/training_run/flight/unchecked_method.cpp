#include "touchstone/examples/training_run/flight/fleet.hpp"
#include "touchstone/examples/training_run/flight/method.hpp"

namespace touchstone::training {
namespace {

class UncheckedMethod final : public FleetMethod {
 public:
  using FleetMethod::FleetMethod;

  std::string_view name() const noexcept override { return "no check"; }
  std::string_view backend() const noexcept override { return "-"; }
  void frame(std::span<const Command> commands, std::span<const ArmCommand> arm_commands,
             FlightLog&) noexcept override {
    for (const Command& command : commands) fleet_.execute(command);
    for (const ArmCommand& command : arm_commands) fleet_.execute(command);
  }
};

}  // namespace

std::unique_ptr<Method> make_unchecked_method(const Setting& setting) {
  return std::make_unique<UncheckedMethod>(setting);
}

}  // namespace touchstone::training
