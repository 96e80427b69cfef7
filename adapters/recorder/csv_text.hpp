#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

// Private to this folder.

namespace touchstone::recorder {

/// The columns of a record, in order: the first line of every file.
inline constexpr std::string_view kHeader =
    "record,frame,time,object,other,solid,other_solid,event,part,s,"
    "r00,r01,r02,r10,r11,r12,r20,r21,r22,x,y,z,"
    "separation,nx,ny,nz,ax,ay,az,bx,by,bz,"
    "end_separation,end_nx,end_ny,end_nz,end_ax,end_ay,end_az,end_bx,end_by,end_bz,count";

enum Column : int {
  kRecord,
  kFrame,
  kTime,
  kObject,
  kOther,
  kSolid,
  kOtherSolid,
  kEvent,
  kPart,
  kS,  //
  kPose,
  kSeparation = kPose + 12,
  kEndSeparation = kSeparation + 10,
  kCount = kEndSeparation + 10,
  kColumns
};

/// As RFC 4180: quoted where it holds a comma, a quote or a line end.
std::string csv_field(std::string_view text);

/// Lines of a record in memory of fixed size.
class CsvText {
 public:
  static constexpr std::size_t kLongestField = 4096;  ///< of text, quoted [bytes]
  static constexpr std::size_t kLongestLine = 2 * kLongestField + 2048;

  explicit CsvText(std::size_t bytes);

  bool has_room_for_line() const { return text_.size() + kLongestLine <= text_.capacity(); }
  std::string_view text() const { return {text_.data(), text_.size()}; }
  std::size_t size() const { return text_.size(); }
  void clear() { text_.clear(); }

  void start_line(std::string_view record);
  /// Empty fields up to `column` are filled in. @pre columns of a line come in rising order
  void put(int column, std::string_view field);
  void put(int column, std::uint64_t value);
  /// The shortest text that reads back as the same double.
  void put(int column, double value);
  void end_line();
  /// After start_line(kHeader): nothing is filled in.
  void end_header() { text_.push_back('\n'); }

 private:
  void go_to(int column);
  void append(std::string_view text);

  std::vector<char> text_;  // never beyond its first capacity
  int column_ = 0;
};

}  // namespace touchstone::recorder
