// Prints the head of a page of figures: page_head TITLE COMMAND. Called by write_pages.

#include <fmt/core.h>

#include "touchstone/examples/program/terminal/machine.hpp"

int main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(stderr, "page_head TITLE COMMAND\n");
    return 2;
  }
  fmt::print("{}", touchstone::program::page_head(argv[1], argv[2]));
  return 0;
}
