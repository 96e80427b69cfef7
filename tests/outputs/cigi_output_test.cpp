#include "touchstone/adapters/cigi/cigi_output.hpp"

#include <gmock/gmock.h>

#include <cerrno>
#include <set>

#include "cigi_fixture.hpp"
#include "output_fixture.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

namespace touchstone {
namespace {

using namespace cigi;
using ::testing::HasSubstr;

CigiOptions options_for(const Listener& listener) {
  CigiOptions options;
  options.port = listener.port();
  return options;
}

TEST(CigiOutput, SendsWhereObjectsAre) {
  // Two objects, one with a type of its own, below an entity.
  Listener listener;
  CigiOptions options = options_for(listener);
  options.anchor = AttachedTo{300, z_up()};
  options.entities = {{"object 1", 77, 1234, z_up()}};
  CigiOutput output(options);
  announce(output, 2);
  const auto frames = make_frames(20, 2, 1);
  // Each frame arrives with its number and time.
  for (const MadeFrame& frame : frames) {
    output.write(frame.view());
    const Message message = receive_message(listener);
    EXPECT_EQ(message.control.host_frame, frame.frame);
    EXPECT_TRUE(message.control.is_timestamp_valid);
    EXPECT_NEAR(message.control.timestamp, frame.time * 1e5, 0.5);
    EXPECT_EQ(message.control.mode, IgMode::operate);
    // Entities and their poses.
    ASSERT_EQ(message.entities.size(), 2u);
    EXPECT_EQ(message.entities[0].id, 1);
    EXPECT_EQ(message.entities[0].type, 1);
    EXPECT_EQ(message.entities[1].id, 77);
    EXPECT_EQ(message.entities[1].type, 1234);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(message.entities[i].state, EntityState::active);
      EXPECT_EQ(message.entities[i].parent, 300);
      const Pose X_WE = pose_from(options.anchor, message.entities[i]);
      EXPECT_EQ(X_WE.p, frame.poses[i].X_WO.p);
      const Matrix3 R = i == 0 ? frame.poses[i].X_WO.R : compose(frame.poses[i].X_WO, z_up()).R;
      EXPECT_LT((X_WE.R - R).cwiseAbs().maxCoeff(), 5e-7);
    }
  }
  EXPECT_EQ(output.status().delivered, 20u);
  EXPECT_EQ(output.status().errors, 0u);
}

// All that moved, and the others in turn, in a datagram that Ethernet carries whole.
TEST(CigiOutput, OneDatagramAFrameBelowTheMtu) {
  // All objects are new in the first frame.
  Listener listener;
  CigiOutput output(options_for(listener));
  announce(output, 100);
  auto frames = make_frames(12, 100, 2);
  output.write(frames[0].view());  // all are new: IP has to split this one
  EXPECT_EQ(listener.receive()->size(), 24u + 100u * 48u);
  EXPECT_EQ(output.long_datagrams(), 1u);

  // Afterwards what moved comes first, and others in turn until all were sent.
  std::set<std::uint16_t> seen;
  for (std::size_t k = 1; k < 12; ++k) {
    frames[k].poses = frames[k - 1].poses;
    frames[k].poses[40].X_WO.p.x() += 0.1;  // one moves
    output.write(frames[k].view());
    const auto bytes = listener.receive();
    EXPECT_EQ(bytes->size(), 24u + 30u * 48u);
    const Message message = read_message(*bytes);
    EXPECT_EQ(message.entities[0].id, 41);
    std::set<std::uint16_t> in_this;
    for (const EntityControl& entity : message.entities) in_this.insert(entity.id);
    EXPECT_EQ(in_this.size(), 30u);
    seen.insert(in_this.begin(), in_this.end());
    if (k >= 4) {
      EXPECT_EQ(seen.size(), 100u);  // 3 * 29 others are 87, 4 * 29 more than 99
    }
  }
  EXPECT_EQ(output.long_datagrams(), 1u);
}

TEST(CigiOutput, WhatIsGoneIsDestroyedAgainAndAgain) {
  Listener listener;
  CigiOutput output(options_for(listener));
  announce(output, 3);
  auto frames = make_frames(15, 3, 3);
  output.write(frames[0].view());
  receive_message(listener);
  for (std::size_t k = 1; k < 15; ++k) {
    frames[k].poses.erase(frames[k].poses.begin() + 1);
    output.write(frames[k].view());
    const Message message = receive_message(listener);
    const bool is_commanded = k <= CigiOutput::kFarewells;
    ASSERT_EQ(message.entities.size(), is_commanded ? 3u : 2u);
    if (is_commanded) {
      EXPECT_EQ(message.entities[1].id, 2);
      EXPECT_EQ(message.entities[1].state, EntityState::destroyed);
    }
  }
  // It comes again, by the same name and in another slot: the same entity.
  output.add_object({{9, 4}, "object 1"});
  MadeFrame again = make_frames(1, 3, 4)[0];
  again.poses[1].object = {9, 4};
  output.write(again.view());
  const Message message = receive_message(listener);
  std::set<std::uint16_t> ids;
  for (const EntityControl& entity : message.entities) {
    ids.insert(entity.id);
    EXPECT_EQ(entity.state, EntityState::active);
  }
  EXPECT_EQ(ids, (std::set<std::uint16_t>{1, 2, 3}));
}

TEST(CigiOutput, HearsTheImageGenerator) {
  Listener listener;
  CigiOptions options = options_for(listener);
  options.database = 5;
  CigiOutput output(options);
  announce(output, 1);
  const auto frames = make_frames(3, 1, 5);
  output.write(frames[0].view());
  EXPECT_EQ(receive_message(listener).control.database, 5);
  Bytes junk(10, std::byte{1});
  listener.answer(junk);
  // Start of Frame, little-endian: database -5 (loading), operate, frame 258.
  Bytes bytes(24, std::byte{0});
  bytes[0] = std::byte{101}, bytes[1] = std::byte{24}, bytes[2] = std::byte{3}, bytes[3] = std::byte{0xfb};
  bytes[5] = std::byte{0x31}, bytes[7] = std::byte{0x80}, bytes[8] = std::byte{2}, bytes[9] = std::byte{1};
  listener.answer(bytes);
  output.write(frames[1].view());
  const Message message = receive_message(listener);
  EXPECT_EQ(message.control.last_ig_frame, 258u);
  EXPECT_EQ(message.control.database, 0);  // it is on its way: not asked for again
  ASSERT_TRUE(output.last_start_of_frame().has_value());
  EXPECT_EQ(output.last_start_of_frame()->mode, IgMode::operate);
}

TEST(CigiOutput, AbsentReceiverIsCountedAndTheRunGoesOn) {
  CigiOptions options;
  {
    const Listener listener;  // gone at once: nobody has this port
    options.port = listener.port();
  }
  CigiOutput output(options);
  announce(output, 5);
  for (const MadeFrame& frame : make_frames(1000, 5, 6)) output.write(frame.view());
  const OutputStatus status = output.status();
  EXPECT_EQ(status.offered, 1000u);
  expect_adds_up(status);
  EXPECT_GT(status.errors, 500u);
  EXPECT_EQ(status.last_error, ECONNREFUSED);
}

TEST(CigiOutput, ReceiverThatComesLateIsServed) {
  CigiOptions options;
  auto listener = std::make_unique<Listener>();
  options.port = listener->port();
  CigiOutput output(options);
  announce(output, 5);
  const auto frames = make_frames(40, 5, 7);
  for (const MadeFrame& frame : frames) output.write(frame.view());
  EXPECT_EQ(output.status().delivered, 40u);
  for (std::uint32_t i = 0; i < 40; ++i) EXPECT_EQ(receive_message(*listener).control.host_frame, i);
}

TEST(CigiOutput, ReceiverThatNeverReadsDelaysNoFrame) {
  const Listener listener;
  CigiOutput output(options_for(listener));
  announce(output, 30);
  const auto frames = make_frames(200, 30, 8);
  // 30 MB against a socket's buffer of some hundred kB: were a send to wait, this would never end.
  for (int i = 0; i < 100; ++i)
    for (const MadeFrame& frame : frames) output.write(frame.view());
  EXPECT_EQ(output.status().offered, 20000u);
  expect_adds_up(output.status());
}

TEST(CigiOutput, WhatHasNotMovedIsSentOnlyInTurn) {
  Listener listener;
  CigiOptions options = options_for(listener);
  options.datagram_bytes = 24;  // nothing in turn
  CigiOutput output(options);
  announce(output, 1300);
  MadeFrame frame = make_frames(1, 1300, 9)[0];
  output.write(frame.view());
  ASSERT_EQ(receive_message(listener).entities.size(), 1300u);
  output.write(frame.view());
  EXPECT_EQ(receive_message(listener).entities.size(), 0u);  // nothing moved
}

TEST(CigiOutput, TimestampWrapsAround) {
  Listener listener;
  CigiOutput output(options_for(listener));
  const double beyond = 0x1p32 / 1e5 + 1.0;
  output.write({0, beyond, {}, {}});
  EXPECT_EQ(receive_message(listener).control.timestamp, 100'000u);
  output.write({1, std::nan(""), {}, {}});
  EXPECT_FALSE(receive_message(listener).control.is_timestamp_valid);
}

TEST(CigiOutput, AllocatesNothingPerFrame) {
  const Listener listener;
  CigiOutput output(options_for(listener));
  announce(output, 40);
  const auto frames = make_frames(100, 40, 10);
  const std::size_t before = allocation_count();
  for (const MadeFrame& frame : frames) output.write(frame.view());
  EXPECT_EQ(allocation_count(), before);
}

TEST(CigiOutput, RefusesBadOptionsByName) {
  CigiOptions options;
  options.host = "no.such.host.invalid";
  try {
    CigiOutput output(options);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no.such.host.invalid"));
  }
  options = {};
  options.entities = {{"a", 3, 1, {}}, {"b", 3, 1, {}}};
  EXPECT_THROW(CigiOutput{options}, InputError);
  options.entities = {{"a", 3, 1, {}}, {"a", 4, 1, {}}};
  EXPECT_THROW(CigiOutput{options}, InputError);
  options = {};
  options.entities = {{"a", 3, 1, {}}};
  options.entities[0].X_OE.R *= -1;
  EXPECT_THROW(CigiOutput{options}, InputError);
}

TEST(CigiOutput, RefusesMoreObjectsThanAMessageHolds) {
  const Listener listener;
  CigiOutput output(options_for(listener));
  EXPECT_EQ(CigiOutput::kMostEntities, 1364u);
  announce(output, 1364);
  EXPECT_THROW(output.add_object({{5000, 0}, "one too many"}), InputError);
}

}  // namespace
}  // namespace touchstone
