#include "touchstone/examples/training_run/fleet.hpp"
#include "touchstone/examples/training_run/way.hpp"

namespace touchstone::training {
namespace {

class UncheckedWay final : public FleetWay {
 public:
  using FleetWay::FleetWay;

  std::string_view name() const noexcept override { return "no check"; }
  std::string_view backend() const noexcept override { return "-"; }
  void frame(std::span<const Command> commands, std::span<const ArmCommand> arm_commands,
             FlightLog&) noexcept override {
    for (const Command& command : commands) fleet_.execute(command);
    for (const ArmCommand& command : arm_commands) fleet_.execute(command);
  }
};

}  // namespace

std::unique_ptr<Way> make_unchecked_way(const Setting& setting) {
  return std::make_unique<UncheckedWay>(setting);
}

}  // namespace touchstone::training
