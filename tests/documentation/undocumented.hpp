#pragma once

// Read by Doxygen alone: this head and each name are to be found undocumented but for those that say
// otherwise.

namespace touchstone {

class Class {
 public:
  int member_that_is_free_to_be = 0;
};

struct Struct {
  struct Nested {
    int member_that_is_free_to_be = 0;
  };
  enum class Inner { value };
  int member_that_is_free_to_be = 0;
};

enum class Enumeration { value };

void function(int argument);
using Alias = int;
inline constexpr int kConstant = 1;

/// Documented.
struct Documented {
  int member_that_is_free_to_be = 0;
};
/// Documented.
void documented();

}  // namespace touchstone

namespace touchstone::without_a_line {

void unseen();

}  // namespace touchstone::without_a_line
