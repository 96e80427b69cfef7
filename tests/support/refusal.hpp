#pragma once

#include <gtest/gtest.h>

#include <string>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {

/// Returns the message, of one line, of the InputError that `act` throws; "accepted" where it throws none.
template <class Act>
std::string refusal_of(Act&& act) {
  try {
    act();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    return error.what();
  }
  return "accepted";
}

}  // namespace touchstone
