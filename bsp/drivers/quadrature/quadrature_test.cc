#include "bsp/drivers/quadrature/quadrature.h"

#include <gtest/gtest.h>

namespace pirvs::bsp {
namespace {

// A leads: A up, B up, A down, B down.
void turn(Quadrature& encoder, int ticks) {
  static int at = 0;
  for (; ticks != 0; ticks += ticks > 0 ? -1 : 1) {
    const int step = (ticks > 0 ? at++ : --at) & 3;
    const int pin = step & 1;
    const bool up = step < 2;
    encoder.add(pin, ticks > 0 ? up : !up);
  }
}

TEST(quadrature, counts_four_ticks_a_period_both_ways) {
  Quadrature encoder;
  encoder.set_levels(false, false);
  turn(encoder, 4003);
  EXPECT_EQ(encoder.ticks(), 4003);
  turn(encoder, -5003);
  EXPECT_EQ(encoder.ticks(), -1000);
  turn(encoder, 1000);
  EXPECT_EQ(encoder.ticks(), 0);
  EXPECT_EQ(encoder.missed(), 0u);
}

TEST(quadrature, counts_nothing_until_it_knows_both_levels) {
  Quadrature encoder;
  encoder.add(0, true);
  EXPECT_EQ(encoder.ticks(), 0);
  encoder.add(1, true);
  EXPECT_EQ(encoder.ticks(), 0) << "B may have been up or down";
  encoder.add(0, false);
  EXPECT_EQ(encoder.ticks(), 1);
}

TEST(quadrature, an_edge_without_its_partner_is_told) {
  Quadrature encoder;
  encoder.set_levels(false, false);
  encoder.add(0, true);
  encoder.add(0, true);
  EXPECT_EQ(encoder.ticks(), 1);
  EXPECT_EQ(encoder.missed(), 1u);
  encoder.lost(3);
  encoder.add(0, false);
  EXPECT_EQ(encoder.ticks(), 1) << "levels must be learnt anew";
  EXPECT_EQ(encoder.missed(), 4u);
}

}  // namespace
}  // namespace pirvs::bsp
