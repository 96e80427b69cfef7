#pragma once

#include <memory>
#include <span>
#include <vector>

#include "touchstone/adapters/mujoco/engine.hpp"
#include "touchstone/adapters/mujoco/xml_model.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone::mujoco {

/// Solids as static geoms of one compiled model: boxes as boxes, others as meshes. Immutable.
class SolidGeoms {
 public:
  /// @throws InputError with MuJoCo's words, for what no single mesh is to blame for.
  explicit SolidGeoms(std::span<const Hexahedron> solids);

  std::size_t solid_count() const { return geoms_.size(); }
  /// False: the compiler refused its mesh.
  bool has(SolidIndex solid) const { return geoms_[solid].id >= 0; }
  bool has_meshes() const { return has_meshes_; }
  /// Largest |coordinate| of its vertices, and at least its size [m].
  double reach(SolidIndex solid) const { return geoms_[solid].reach; }
  /// How far MuJoCo's single-precision vertices are from ours, at most [m].
  double rounding() const { return rounding_; }

  DataHandle make_data() const { return DataHandle(mj_makeData(model_.get())); }
  /// @pre has(solid)
  void place(SolidIndex solid, const Pose& X_WS, mjData& data) const;

  struct Found {
    int count;        ///< contacts written, at most mjMAXCONPAIR
    bool is_swapped;  ///< MuJoCo's geom 1 is b
  };
  /// MuJoCo's own function for the pair, as placed. @pre has() both; room for mjMAXCONPAIR contacts.
  Found collide(SolidPair pair, mjData& data, std::span<EngineContact> contacts) const;

 private:
  struct Geom {
    int id;  ///< below 0: refused
    Pose X_SG;
    double reach;
    void refuse() { id = -1; }
  };

  void compile(std::span<const Hexahedron> solids);
  void measure(const Hexahedron& solid, Geom& geom);
  bool is_mesh(int geom) const { return model_->geom_type[geom] == mjGEOM_MESH; }

  ModelHandle model_;
  std::vector<Geom> geoms_;
  double rounding_ = 0.0;
  bool has_meshes_ = false;
};

}  // namespace touchstone::mujoco
