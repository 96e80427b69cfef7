#pragma once

#include <mujoco/mujoco.h>

#include <cstring>
#include <memory>
#include <string>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::mujoco {

struct ModelDeleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
struct DataDeleter {
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using ModelHandle = std::unique_ptr<mjModel, ModelDeleter>;
using DataHandle = std::unique_ptr<mjData, DataDeleter>;

/// A model from MJCF text.
/// @throws InputError with MuJoCo's words.
inline ModelHandle load_model(const std::string& xml) {
  constexpr const char* kName = "model.xml";
  const auto files = std::make_unique<mjVFS>();  // too large for a stack
  mj_defaultVFS(files.get());
#if mjVERSION_HEADER >= 320
  mj_addBufferVFS(files.get(), kName, xml.data(), static_cast<int>(xml.size()));
#else
  mj_makeEmptyFileVFS(files.get(), kName, static_cast<int>(xml.size()));
  std::memcpy(files->filedata[0], xml.data(), xml.size());
#endif
  char error[1000] = "";
  ModelHandle model(mj_loadXML(kName, files.get(), error, sizeof(error)));
  mj_deleteVFS(files.get());
  if (!model) throw InputError(std::string("MuJoCo: ") + error);
  return model;
}

}  // namespace touchstone::mujoco
