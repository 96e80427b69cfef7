#include "examples/training_run/fleet.hpp"
#include "examples/training_run/way.hpp"

namespace touchstone::training {
namespace {

class UncheckedWay final : public Way {
 public:
  explicit UncheckedWay(const Setting& setting) : setting_(&setting), fleet_(setting) {}

  std::string_view name() const noexcept override { return "no check"; }
  std::string_view backend() const noexcept override { return "-"; }
  void act(const Action& action) override { fleet_.formation.apply(action, fleet_.X_WO); }
  void frame(std::span<const Command> commands, std::span<const ArmCommand> arm_commands,
             FlightLog&) noexcept override {
    for (const Command& command : commands) fleet_.execute(command);
    for (const ArmCommand& command : arm_commands) fleet_.execute(command);
  }
  void attach(FrameOutput& output) override { fleet_.attach(*setting_, output); }
  void send(double time) noexcept override { fleet_.send(time); }
  std::span<const Pose> poses() const noexcept override { return fleet_.X_WO; }
  std::span<const double> joints() const noexcept override { return fleet_.joints; }
  const Formation& formation() const noexcept override { return fleet_.formation; }

 private:
  const Setting* setting_;
  Fleet fleet_;
};

}  // namespace

std::unique_ptr<Way> make_unchecked_way(const Setting& setting) {
  return std::make_unique<UncheckedWay>(setting);
}

}  // namespace touchstone::training
