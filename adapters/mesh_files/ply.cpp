// PLY (Turk, "The PLY polygon file format", 1994): a header that lists elements and their properties, then
// the elements' rows as text or in either byte order. Read are `vertex` x, y, z and `face` vertex_indices (or
// vertex_index); what else there is (colours, normals, edges) is passed by.
#include <bit>
#include <cstring>

#include "touchstone/adapters/mesh_files/soup.hpp"
#include "touchstone/contact_core/fit/meshes/text_scanner.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::mesh_files {
namespace {

constexpr std::size_t kReportEvery = 1 << 16;

enum class Type : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct Property {
  std::string name;
  bool is_list = false;
  Type count = Type::uint8;  ///< lists
  Type value = Type::float32;
};

struct Element {
  std::string name;
  std::size_t rows = 0;
  std::vector<Property> properties = {};
};

enum class Coding : std::uint8_t { text, little_endian, big_endian };

struct Header {
  Coding coding = Coding::text;
  std::vector<Element> elements;
};

Type type_of(std::string_view word, const TextScanner& text) {
  constexpr std::array<std::array<std::string_view, 2>, 8> kNames = {{{"char", "int8"},
                                                                      {"uchar", "uint8"},
                                                                      {"short", "int16"},
                                                                      {"ushort", "uint16"},
                                                                      {"int", "int32"},
                                                                      {"uint", "uint32"},
                                                                      {"float", "float32"},
                                                                      {"double", "float64"}}};
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (word == kNames[i][0] || word == kNames[i][1]) return static_cast<Type>(i);
  text.fail("'" + TextScanner::shown(word) + "' is no type of a property");
}

std::size_t size_of(Type type) {
  constexpr std::array<std::size_t, 8> kSizes = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

Property read_property(TextScanner& text) {
  Property property;
  std::string_view word = text.word_in_line();
  property.is_list = word == "list";
  if (property.is_list) {
    property.count = type_of(text.word_in_line(), text);
    word = text.word_in_line();
  }
  property.value = type_of(word, text);
  property.name = std::string(text.word_in_line());
  return property;
}

std::size_t read_count(TextScanner& text) {
  const double count = text.number(text.word_in_line());
  constexpr double kMost = 4e9;  // indices have 32 bits
  if (!(count >= 0.0 && count <= kMost)) text.fail("an element cannot have that many rows");
  return static_cast<std::size_t>(count);
}

Coding read_coding(TextScanner& text) {
  const std::string_view word = text.word_in_line();
  if (word == "ascii") return Coding::text;
  if (word == "binary_little_endian") return Coding::little_endian;
  if (word == "binary_big_endian") return Coding::big_endian;
  text.fail("unknown format '" + TextScanner::shown(word) + "'");
}

Header read_header(TextScanner& text) {
  if (text.word() != "ply") text.fail("no PLY file: it does not begin with 'ply'");
  Header header;
  bool is_coded = false;
  for (std::string_view word = text.word(); word != "end_header"; word = text.word()) {
    if (word == "format") {
      header.coding = read_coding(text);
      is_coded = true;
    } else if (word == "element") {
      const std::string name{text.word_in_line()};
      header.elements.push_back({name, read_count(text)});
    } else if (word == "property" && !header.elements.empty()) {
      header.elements.back().properties.push_back(read_property(text));
    } else if (word.empty()) {
      text.fail("the header has no end");
    } else if (word != "comment" && word != "obj_info") {
      text.fail("'" + TextScanner::shown(word) + "' in the header");
    }
    text.skip_line();
  }
  text.skip_line();
  if (!is_coded) text.fail("the header names no format");
  return header;
}

/// Values one after the other, in whichever coding.
class Values {
 public:
  Values(std::string_view bytes, Coding coding, TextScanner& text, const ReadTask& task)
      : bytes_(bytes), coding_(coding), text_(&text), task_(&task), at_(text.position()) {}

  void begin_row(const std::string& element, std::size_t row) { element_ = &element, row_ = row; }
  double next(Type type) {
    if (coding_ == Coding::text) {
      const std::string_view word = text_->word();
      if (word.empty()) fail("the file ends: it is truncated");
      return text_->number(word);
    }
    const std::size_t size = size_of(type);
    if (bytes_.size() - at_ < size) fail("the file ends: it is truncated");
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t from = coding_ == Coding::little_endian ? size - 1 - i : i;
      bits = bits << 8U | static_cast<unsigned char>(bytes_[at_ + from]);
    }
    at_ += size;
    return value_of(bits, type);
  }
  /// As next(), of a value that is not read: any word will do.
  void pass(Type type) {
    if (coding_ != Coding::text) {
      next(type);
    } else if (text_->word().empty()) {
      fail("the file ends: it is truncated");
    }
  }
  /// The length of a list; 1 of a single value. Below 0 as 0.
  std::size_t count(const Property& property) {
    if (!property.is_list) return 1;
    const double count = next(property.count);
    constexpr double kMost = 4e9;
    if (count > kMost) fail("a list of " + TextScanner::shown(std::to_string(count)) + " values");
    return count > 0.0 ? static_cast<std::size_t>(count) : 0;
  }
  void skip(const Property& property) {
    const std::size_t values = count(property);
    for (std::size_t i = 0; i < values; ++i) pass(property.value);
  }
  [[noreturn]] void fail(const std::string& reason) const {
    task_->fail(*element_ + " " + std::to_string(row_) + ": " + reason);
  }

 private:
  static double value_of(std::uint64_t bits, Type type) {
    switch (type) {
      case Type::int8:
        return static_cast<std::int8_t>(bits);
      case Type::int16:
        return static_cast<std::int16_t>(bits);
      case Type::int32:
        return static_cast<std::int32_t>(bits);
      case Type::float32:
        return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
      case Type::float64:
        return std::bit_cast<double>(bits);
      default:
        return static_cast<double>(bits);
    }
  }

  std::string_view bytes_;
  Coding coding_;
  TextScanner* text_;
  const ReadTask* task_;
  std::size_t at_;
  const std::string* element_ = nullptr;
  std::size_t row_ = 0;
};

void read_vertex(const Element& element, Values& values, Soup& soup) {
  Vector3 v = Vector3::Zero();
  for (const Property& property : element.properties) {
    const bool is_coordinate = property.name.size() == 1 && property.name >= "x" && property.name <= "z";
    if (!is_coordinate) {
      values.skip(property);
      continue;
    }
    const std::size_t count = values.count(property);
    for (std::size_t i = 0; i < count; ++i) {
      const double value = values.next(property.value);
      if (!(value - value == 0.0)) values.fail("a coordinate is not finite");
      v[property.name[0] - 'x'] = value;
    }
  }
  soup.vertices.push_back(v);
}

/// As a fan; see obj.cpp.
void read_polygon(const Property& property, Values& values, Soup& soup, const ReadTask& task) {
  const std::size_t count = values.count(property);
  if (count < 3) values.fail("it has " + std::to_string(count) + " corners");
  std::array<std::uint32_t, 3> corner{};
  for (std::size_t i = 0; i < count; ++i) {
    const double index = values.next(property.value);
    if (!(index >= 0.0 && index < static_cast<double>(soup.vertices.size())))
      values.fail("vertex " + figure(index) + " of " + std::to_string(soup.vertices.size()));
    corner[i < 2 ? i : 2] = static_cast<std::uint32_t>(index);
    if (i < 2) continue;
    task.require_room(soup.triangles.size());
    soup.triangles.push_back(corner);
    corner[1] = corner[2];
  }
  soup.polygons_split += count > 3;
}

void read_face(const Element& element, Values& values, Soup& soup, const ReadTask& task) {
  for (const Property& property : element.properties) {
    if (property.is_list && (property.name == "vertex_indices" || property.name == "vertex_index")) {
      read_polygon(property, values, soup, task);
      continue;
    }
    values.skip(property);
  }
}

void skip_row(const Element& element, Values& values) {
  for (const Property& property : element.properties) values.skip(property);
}

void require_coordinates(const Element& element, const ReadTask& task) {
  for (const char* name : {"x", "y", "z"}) {
    bool is_there = false;
    for (const Property& property : element.properties) is_there = is_there || property.name == name;
    if (!is_there) task.fail(std::string("its vertices have no ") + name);
  }
}

}  // namespace

Soup read_ply(std::string_view bytes, const ReadTask& task) {
  TextScanner text(bytes, task.file);
  const Header header = read_header(text);
  Values values(bytes, header.coding, text, task);
  Soup soup;
  for (const Element& element : header.elements) {
    if (element.name == "vertex") require_coordinates(element, task);
    if (element.properties.empty()) continue;
    for (std::size_t row = 0; row < element.rows; ++row) {
      values.begin_row(element.name, row);
      if (element.name == "vertex")
        read_vertex(element, values, soup);
      else if (element.name == "face")
        read_face(element, values, soup, task);
      else
        skip_row(element, values);
      if (row % kReportEvery == 0)
        task.advance(0.5 * static_cast<double>(row) / static_cast<double>(element.rows) +
                     (element.name == "face" ? 0.5 : 0.0));
    }
  }
  return soup;
}

}  // namespace touchstone::mesh_files
