#pragma once

#include <vector>

#include "examples/training_run/way.hpp"

namespace touchstone::training {

/// Objects that go wherever they are told, with what they carry.
struct Fleet {
  std::vector<Pose> X_WO;
  Formation formation;

  explicit Fleet(const Setting& setting) : formation(setting.object_count()) {
    for (const SceneObject& object : setting.scene().objects) X_WO.push_back(object.X_WO);
  }

  void execute(const Command& command) noexcept {
    const CarriedPath path(command.path, formation.X_RO);
    for (std::uint32_t i = 0; i < X_WO.size(); ++i)
      if (formation.root_of(i) == command.object) X_WO[i] = path.at(i, 1.0).X_WO;
  }
};

}  // namespace touchstone::training
