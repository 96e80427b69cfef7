#include <tinyxml2.h>

#include "touchstone/adapters/robots/text_file.hpp"
#include "touchstone/adapters/urdf/urdf.hpp"

namespace touchstone::urdf {
namespace {

[[noreturn]] void reject(const std::string& source, int line, const std::string& reason) {
  throw InputError(source + ":" + std::to_string(line) + ": " + reason);
}

}  // namespace

std::vector<ExemptPair> parse_srdf(const std::string& xml, const std::string& source) {
  tinyxml2::XMLDocument document;
  if (document.Parse(xml.data(), xml.size()) != tinyxml2::XML_SUCCESS)
    reject(source, document.ErrorLineNum(), document.ErrorStr());
  const tinyxml2::XMLElement* robot = document.FirstChildElement("robot");
  if (!robot) throw InputError(source + ": no <robot> element");
  for (const char* element : {"disable_default_collisions", "enable_collisions"})
    if (const tinyxml2::XMLElement* found = robot->FirstChildElement(element))
      reject(source, found->GetLineNum(),
             std::string("<") + element + "> is not supported: list the pairs as <disable_collisions>");
  std::vector<ExemptPair> pairs;
  for (const tinyxml2::XMLElement* entry = robot->FirstChildElement("disable_collisions"); entry;
       entry = entry->NextSiblingElement("disable_collisions")) {
    const char* first = entry->Attribute("link1");
    const char* second = entry->Attribute("link2");
    if (!first || !second) reject(source, entry->GetLineNum(), "<disable_collisions> needs link1 and link2");
    pairs.push_back({first, second});
  }
  return pairs;
}

std::vector<ExemptPair> load_srdf(const std::filesystem::path& file) {
  return parse_srdf(read_robot_text(file), file.string());
}

}  // namespace touchstone::urdf
