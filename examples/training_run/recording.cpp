#include "examples/training_run/recording.hpp"

#include <fmt/format.h>

#include <iterator>

#include "examples/compare_backends/csv.hpp"

namespace touchstone::training {

Recording::Recording(const Setting& setting) : setting_(&setting) {
  for (std::uint32_t i = 0; i < setting.object_count(); ++i)
    if (setting.may_move(i)) movers_.push_back(i);
  times_.reserve(setting.frame_count() + 1);
  X_WO_.reserve((setting.frame_count() + 1) * movers_.size());
}

void Recording::on_frame(std::size_t, double time, std::span<const Pose> X_WO) noexcept {
  if (times_.size() == times_.capacity()) return;
  times_.push_back(time);
  for (const std::uint32_t object : movers_) X_WO_.push_back(X_WO[object]);
}

std::string Recording::csv() const {
  std::string text = "frame,time,object,x,y,z,r00,r01,r02,r10,r11,r12,r20,r21,r22\n";
  auto out = std::back_inserter(text);
  for (std::size_t frame = 0; frame < times_.size(); ++frame) {
    for (std::size_t i = 0; i < movers_.size(); ++i) {
      const Pose& X = X_WO_[frame * movers_.size() + i];
      fmt::format_to(out, "{},{},{},{},{},{}", frame, times_[frame],
                     comparison::csv_text(setting_->object_name(movers_[i])), X.p.x(), X.p.y(), X.p.z());
      for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) fmt::format_to(out, ",{}", X.R(row, column));
      text += '\n';
    }
  }
  return text;
}

}  // namespace touchstone::training
