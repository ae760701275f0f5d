#include "modules/tracking/tracker.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;
using testing::Rig;
using testing::Sway;

constexpr TimeNs kFrame_ns = 50'000'000, kSample_ns = 5'000'000;

// Front-ends on grey images, which nothing can be detected in or followed on: tracks are where a
// test starts them.
struct Eyes {
  Eyes() : rig(CameraModel::kPinholeRadtan), grey(752 * 480, 128) {
    FrontendParams params;
    params.corner_response_min = 1e6f;
    for (int c = 0; c < kCamerasMax; ++c) {
      frontend[c].configure(rig.camera[c], params);
      EXPECT_EQ(frontend[c].process({grey.data(), 752, 480, 752}, 1, Vec3(0, 1, 0)), Status::kOk);
      EXPECT_TRUE(frontend[c].tracks().empty());
    }
  }
  Rig rig;
  std::vector<uint8_t> grey;
  std::unique_ptr<Frontend[]> frontend = std::make_unique<Frontend[]>(kCamerasMax);
};

// A map of points before the rig, and who sees what of it.
struct Scene : Eyes {
  Scene() {
    associator->configure(rig.camera, kCamerasMax, MatchingParams{}, frontend.get());
    places->configure(rig.camera, kCamerasMax, ImuNoise{}, FilterParams{}, MatchingParams{},
                      params);
    snapshot->keyframe = 100;
    snapshot->epoch = 1;
    for (int i = 0; i < 150; ++i) {
      const double x = random.uniform(2, 6);
      MapPoint point{};
      point.id = {7, static_cast<uint16_t>(i)};
      point.p_W = Vec3(x, random.uniform(-0.6, 0.6) * x, random.uniform(-0.4, 0.4) * x);
      point.cov = Mat3::Identity() * 1e-6;
      for (uint64_t& w : point.descriptor.w)
        w = (uint64_t{random.engine()} << 32) | random.engine();
      const Vec3 towards = rig.camera[0].T_BC.p - point.p_W;
      point.distance_m = static_cast<float>(towards.norm());
      point.view_W = towards.normalized();
      point.first_keyframe = point.last_keyframe = 20;
      point.epoch = 1;
      EXPECT_TRUE(snapshot->points.push_back(point));
    }
  }
  // Each point that a camera at T_WB sees has a track there.
  void look(const SE3& T_WB) {
    for (int c = 0; c < kCamerasMax; ++c) {
      while (!frontend[c].tracks().empty()) frontend[c].erase(0);
      for (const MapPoint& point : snapshot->points) {
        Vec2 uv;
        if (!rig.see(T_WB, c, point.p_W, uv)) continue;
        const float x = static_cast<float>(uv.x()), y = static_cast<float>(uv.y());
        (void)frontend[c].start_track(x, y, &point.descriptor);
      }
    }
    associator->take(*snapshot, T_WB, 0);
  }
  LoopDecision test_loop(const SE3& T_WB, double sigma_m, uint32_t drifted_after = 0) {
    MapError error{Mat6::Zero(), T_WB.p};
    error.cov.diagonal().tail<4>().setConstant(sigma_m * sigma_m);
    return places->test_loop(t += 1'000'000'000, T_WB, error, drifted_after, *associator);
  }

  Random random{5};
  TrackerParams params;
  TimeNs t = 10'000'000'000;
  std::unique_ptr<Associator> associator = std::make_unique<Associator>();
  std::unique_ptr<Places> places = std::make_unique<Places>();
  std::unique_ptr<MapSnapshot> snapshot = std::make_unique<MapSnapshot>();
};

SE3 off_by(const Vec3& p) {
  SE3 T;
  T.p = p;
  return T;
}

// ---- places ------------------------------------------------------------------------------------

TEST(places, a_known_place_is_found_and_not_asked_for_too_often) {
  Scene s;
  const SE3 truth = off_by(Vec3(0.2, -0.1, 0.05));
  s.look(truth);
  ASSERT_EQ(s.places->recognise(s.t, PlaceRule::kSame, Mat3::Identity(), *s.associator),
            PlaceAnswer::kFound);
  EXPECT_LT((s.places->found().T_WB.p - truth.p).norm(), 0.02);
  EXPECT_EQ(s.places->found().epoch, 1);
  EXPECT_EQ(s.places->recognise(s.t + 1, PlaceRule::kSame, Mat3::Identity(), *s.associator),
            PlaceAnswer::kNotAsked);
  s.places->hurry();
  EXPECT_EQ(s.places->recognise(s.t + 2, PlaceRule::kOther, Mat3::Identity(), *s.associator),
            PlaceAnswer::kUnknown)
      << "all points are of the snapshot's own epoch";
}

TEST(places, a_loop_closes_by_what_the_pose_is_off) {
  Scene s;
  s.look(SE3{});
  const Vec3 off(0.3, -0.2, 0.1);
  const LoopDecision loop = s.test_loop(off_by(off), 0.3);
  ASSERT_EQ(loop.verdict, LoopDecision::Verdict::kCloses);
  EXPECT_LT((loop.off.tail<3>() + off).norm(), 0.02) << "the pose has to go back";
  EXPECT_LT(std::abs(loop.off[0]), 0.01) << "heading was right";
  EXPECT_EQ(loop.closes_to, 20u);
  EXPECT_LT((loop.T * off_by(off)).p.norm(), 0.02);
}

TEST(places, no_loop_where_the_pose_is_right_or_cannot_be_so_wrong) {
  Scene s;
  s.look(SE3{});
  EXPECT_EQ(s.test_loop(SE3{}, 0.3).verdict, LoopDecision::Verdict::kNone);
  EXPECT_EQ(s.test_loop(off_by(Vec3(0.3, -0.2, 0.1)), 0.01).verdict,
            LoopDecision::Verdict::kImplausible);
  for (MapPoint& point : s.snapshot->points) point.last_keyframe = 90;
  s.look(SE3{});
  EXPECT_EQ(s.test_loop(off_by(Vec3(0.3, -0.2, 0.1)), 0.3).verdict, LoopDecision::Verdict::kNone)
      << "no point is old";
}

TEST(places, after_dead_reckoning_what_came_before_is_old_wherever_it_should_be) {
  Scene s;
  for (MapPoint& point : s.snapshot->points) point.last_keyframe = 90;
  s.look(SE3{});
  const SE3 far = off_by(Vec3(-9, 1, 0));  // from there none of the points is in view
  EXPECT_EQ(s.test_loop(far, 5, 89).verdict, LoopDecision::Verdict::kNone) << "seen since";
  const LoopDecision loop = s.test_loop(far, 5, 90);
  ASSERT_EQ(loop.verdict, LoopDecision::Verdict::kCloses);
  EXPECT_LT((loop.T * far).p.norm(), 0.02);
  EXPECT_EQ(s.test_loop(far, 0.5, 90).verdict, LoopDecision::Verdict::kImplausible);
  for (MapPoint& point : s.snapshot->points) point.p_W *= 3 / point.p_W.x();
  s.look(SE3{});
  EXPECT_EQ(s.test_loop(far, 5, 90).verdict, LoopDecision::Verdict::kNone) << "one plane";
}

TEST(places, tracked_points_that_are_as_old_hold_the_pose) {
  Scene s;
  s.params.loop_held_max = 0.5f;
  s.places->configure(s.rig.camera, kCamerasMax, ImuNoise{}, FilterParams{}, MatchingParams{},
                      s.params);
  s.look(SE3{});
  ASSERT_EQ(s.test_loop(off_by(Vec3(0.3, -0.2, 0.1)), 0.3).verdict, LoopDecision::Verdict::kCloses);
  s.associator->adopt(s.places->found());
  EXPECT_EQ(s.test_loop(off_by(Vec3(0.3, -0.2, 0.1)), 0.3).verdict, LoopDecision::Verdict::kHeld);
}

// ---- data association --------------------------------------------------------------------------

TEST(associator, a_dead_tracks_landmark_is_not_its_successors) {
  Scene s;
  s.look(SE3{});
  ASSERT_EQ(s.places->recognise(s.t, PlaceRule::kSame, Mat3::Identity(), *s.associator),
            PlaceAnswer::kFound);
  s.associator->adopt(s.places->found());
  StandstillDetector moving;
  moving.configure(StandstillParams{});
  moving.reset();
  const size_t all = s.associator->collect(1, moving).size();
  ASSERT_GT(all, 100u);
  const size_t shown = s.places->found().matches[0].track;  // of the left camera
  const Track dead = s.associator->tracks(0)[shown];
  ASSERT_TRUE(s.associator->landmark(0, dead).valid());
  s.frontend[0].erase(shown);
  ASSERT_NE(s.frontend[0].start_track(dead.x, dead.y, nullptr), 0u);
  const Track& successor = s.associator->tracks(0).back();
  ASSERT_EQ(successor.slot, dead.slot);
  EXPECT_FALSE(s.associator->landmark(0, successor).valid());
  EXPECT_EQ(s.associator->collect(1, moving).size(), all - 1);
}

TEST(associator, misfits_in_a_row_end_a_track_and_one_fit_forgives) {
  Scene s;
  s.look(SE3{});
  s.associator->match({SE3{}, Mat6::Identity() * 1e-6});
  StandstillDetector moving;
  moving.configure(StandstillParams{});
  moving.reset();
  const auto frame = [&](Gate first) {
    Correspondences& seen = s.associator->collect(1, moving);
    seen[0].gate = first;
    return s.associator->drop_misfits(2);
  };
  EXPECT_EQ(frame(Gate::kChi2), 0);
  EXPECT_EQ(frame(Gate::kChi2), 0);
  EXPECT_EQ(frame(Gate::kAccepted), 0);
  EXPECT_EQ(frame(Gate::kChi2), 0);
  EXPECT_EQ(frame(Gate::kChi2), 0);
  EXPECT_EQ(frame(Gate::kChi2), 1);
}

// ---- keyframes ---------------------------------------------------------------------------------

struct Keyframing : Scene {
  Keyframing() {
    keyframer->configure(rig.camera, ImuNoise{}, params, StereoParams{}, ring.get());
    look(SE3{});
    associator->match({SE3{}, Mat6::Identity() * 1e-6});
  }
  bool send(TimeNs time) {
    BodyState state;
    state.t = time;
    KeyframeMessage* message = keyframer->begin(state, false, 1, *associator);
    if (message == nullptr) return false;
    keyframer->end(*message, state);
    return true;
  }
  bool due(double dt_s, const SE3& T_WB = SE3{}) const {
    return keyframer->due(keyframer->last().t + from_seconds(dt_s), T_WB, 0, *associator);
  }
  std::unique_ptr<KeyframeRing> ring = std::make_unique<KeyframeRing>();
  std::unique_ptr<Keyframer> keyframer = std::make_unique<Keyframer>();
};

TEST(keyframer, is_due_by_time_distance_turn_and_unknown_tracks) {
  Keyframing k;
  ASSERT_TRUE(k.send(1'000'000'000));
  EXPECT_FALSE(k.due(0.5)) << "nothing has changed";
  EXPECT_TRUE(k.due(1.1)) << "the longest time";
  EXPECT_TRUE(k.due(0.5, off_by(Vec3(0.41, 0, 0))));
  EXPECT_FALSE(k.due(0.1, off_by(Vec3(0.41, 0, 0)))) << "the shortest time";
  SE3 turned;
  turned.R = so3_exp(Vec3(0, 0, 13 * M_PI / 180));
  EXPECT_TRUE(k.due(0.5, turned));
  k.associator->forget_landmarks();
  EXPECT_TRUE(k.due(0.5)) << "no track shows a known point";
}

TEST(keyframer, a_message_says_what_is_seen_and_too_many_are_dropped) {
  Keyframing k;
  ASSERT_TRUE(k.send(1'000'000'000));
  const KeyframeMessage* message = k.ring->front();
  ASSERT_NE(message, nullptr);
  EXPECT_EQ(message->sequence, 1u);
  ASSERT_EQ(message->observations[0].size(), k.associator->tracks(0).size());
  for (size_t i = 0; i < message->observations[0].size(); ++i) {
    const Track& track = k.associator->tracks(0)[i];
    EXPECT_EQ(message->observations[0][i].track, track.id);
    EXPECT_EQ(message->observations[0][i].landmark, k.associator->landmark(0, track));
  }
  for (size_t i = 1; i < kKeyframeRing; ++i) ASSERT_TRUE(k.send(1'000'000'000)) << i;
  EXPECT_FALSE(k.send(2'000'000'000));
  EXPECT_EQ(k.keyframer->dropped(), 1u);
  EXPECT_EQ(k.keyframer->sent(), kKeyframeRing) << "a dropped one has no number";
  EXPECT_EQ(k.keyframer->last().t, 1'000'000'000);
  while (k.ring->front() != nullptr) k.ring->pop();
  EXPECT_FALSE(k.send(3'000'000'000)) << "what mapping does meanwhile says nothing";
  k.keyframer->note_mapped(2);
  EXPECT_TRUE(k.send(4'000'000'000));
  EXPECT_TRUE(k.send(5'000'000'000));
  EXPECT_FALSE(k.send(6'000'000'000));
  k.keyframer->note_mapped(1);
  EXPECT_EQ(k.keyframer->mapped(), 2u) << "mapping does not go back";
  EXPECT_EQ(k.keyframer->dropped(), 3u);
}

// ---- the estimate ------------------------------------------------------------------------------

TEST(estimate, goes_on_from_a_refined_keyframe_with_the_samples_since) {
  const Sway sway;
  auto history = std::make_unique<ImuHistory>();
  Estimate estimate;
  const Rig rig(CameraModel::kPinholeRadtan);
  estimate.configure(rig.camera, ImuNoise{}, FilterParams{}, 1, history.get());
  history->add(sway.imu(0));
  estimate.begin(sway.state(0), Mat15::Identity() * 1e-4);
  BodyState tracked;
  for (int i = 1; i <= 200; ++i) {
    history->add(sway.imu(i * 0.005));
    estimate.propagate(history->newest());
    if (i == 100) tracked = estimate.state();
  }
  const SE3 before = estimate.state().T_WB;
  BodyState refined = tracked;
  refined.T_WB.p += Vec3(0.1, 0, -0.2);
  ASSERT_TRUE(estimate.restart(refined, Mat15::Identity() * 1e-6));
  EXPECT_EQ(estimate.state().t, refined.t);
  estimate.advance((*history)[150].t);
  EXPECT_EQ(estimate.state().t, (*history)[150].t);
  estimate.advance(history->newest().t);
  EXPECT_EQ(estimate.state().t, history->newest().t);
  EXPECT_LT((estimate.state().T_WB.p - before.p - Vec3(0.1, 0, -0.2)).norm(), 1e-9);

  const SE3 kept = estimate.state().T_WB;
  refined.t += 1;
  EXPECT_FALSE(estimate.restart(refined, Mat15::Identity())) << "no sample is of that time";
  EXPECT_EQ((estimate.state().T_WB.p - kept.p).norm(), 0);
}

// ---- all of it ---------------------------------------------------------------------------------

// One camera at rest before points 3 m away.
struct Resting : Eyes {
  Resting() {
    tracker->configure(rig.camera, 1, ImuNoise{}, TrackingParams{}, frontend.get(), ring.get(),
                       mailbox.get());
    for (int i = 0; i < 48; ++i) {
      EXPECT_NE(frontend[0].start_track(47.0f + 94.0f * static_cast<float>(i % 8),
                                        40.0f + 80.0f * static_cast<float>(i / 8), &descriptor(i)),
                0u);
    }
  }
  static const Descriptor& descriptor(int i) {
    static Descriptor d;
    d.w[0] = static_cast<uint64_t>(i) * 0x9e3779b97f4a7c15u;
    return d;
  }
  void feel() {
    ImuSample sample;
    sample.t = t += kSample_ns;
    sample.f_B = Vec3(0, 0, kGravity_m_s2);
    tracker->add_imu(sample);
  }
  FrameResult frame() {
    for (int i = 0; i < kFrame_ns / kSample_ns; ++i) feel();
    (void)tracker->prepare(0);
    for (size_t i = 0; i < frontend[0].tracks().size(); ++i) {
      Track& track = frontend[0].track(i);
      track.x_last = track.x;
      track.y_last = track.y;
      ++track.age;
    }
    tracker->match();
    return tracker->frame(t, 1);
  }
  bool start() {
    for (int k = 0; k < 60 && !tracker->running(); ++k) (void)frame();
    return tracker->running();
  }
  // What mapping would answer to the newest keyframe: all its tracks have become points, and the
  // body was at `shift`.
  void answer(const Vec3& shift) {
    while (ring->size() > 1) ring->pop();
    const KeyframeMessage& message = *ring->front();
    MapSnapshot& snapshot = mailbox->back();
    snapshot = MapSnapshot{};
    snapshot.keyframe = message.sequence;
    snapshot.epoch = message.epoch;
    snapshot.adjusted = true;
    snapshot.state = message.state;
    snapshot.state.T_WB.p += shift;
    snapshot.cov = Mat15::Identity() * 1e-6;
    for (const Observation& seen : message.observations[0]) {
      Vec3 ray_C;
      ASSERT_TRUE(rig.camera[0].unproject(Vec2(seen.x, seen.y), ray_C));
      MapPoint point{};
      point.id = {3, static_cast<uint16_t>(snapshot.points.size())};
      point.p_W = snapshot.state.T_WB * (rig.camera[0].T_BC * (ray_C * 3));
      point.cov = Mat3::Identity() * 1e-6;
      point.track[0] = seen.track;
      point.in_newest = true;
      point.epoch = message.epoch;
      ASSERT_TRUE(snapshot.points.push_back(point));
    }
    mailbox->publish();
    ring->pop();
  }

  TimeNs t = 1'000'000'000;
  std::unique_ptr<KeyframeRing> ring = std::make_unique<KeyframeRing>();
  std::unique_ptr<MapMailbox> mailbox = std::make_unique<MapMailbox>();
  std::unique_ptr<Tracker> tracker = std::make_unique<Tracker>();
};

TEST(tracker, goes_on_from_the_map_that_its_start_became) {
  Resting r;
  ASSERT_TRUE(r.start());
  EXPECT_EQ(r.tracker->sent(), 1u);
  EXPECT_EQ(r.frame().correspondences, 0) << "no map yet";
  const Vec3 shift(0.1, -0.05, 0.02);
  r.answer(shift);
  const FrameResult result = r.frame();
  EXPECT_EQ(result.correspondences, 48);
  EXPECT_EQ(result.accepted, 48);
  EXPECT_TRUE(result.at_rest);
  EXPECT_EQ(r.tracker->counters().snapshots_late, 0u);
  EXPECT_LT((r.tracker->state().T_WB.p - shift).norm(), 1e-3);
}

TEST(tracker, a_track_that_takes_a_dead_ones_slot_takes_nothing_else) {
  Resting r;
  ASSERT_TRUE(r.start());
  r.answer(Vec3::Zero());
  ASSERT_EQ(r.frame().correspondences, 48);
  const Track dead = r.frontend[0].tracks()[10];
  r.frontend[0].erase(10);
  ASSERT_NE(r.frontend[0].start_track(dead.x, dead.y, nullptr), 0u);
  ASSERT_EQ(r.frontend[0].tracks().back().slot, dead.slot);
  for (int k = 0; k < 10; ++k) EXPECT_EQ(r.frame().correspondences, 47);
  EXPECT_EQ(r.tracker->counters().tracks_dropped, 0u);
}

TEST(tracker, an_interruption_loses_and_the_next_start_continues_the_place) {
  Resting r;
  ASSERT_TRUE(r.start());
  r.answer(Vec3(0.5, 0, 0));
  ASSERT_EQ(r.frame().correspondences, 48);
  r.tracker->interrupt();
  EXPECT_FALSE(r.tracker->running());
  EXPECT_EQ(r.tracker->counters().losses, 1u);
  r.t += 1'000'000'000;
  ASSERT_TRUE(r.start());
  EXPECT_EQ(r.tracker->counters().starts, 2u);
  EXPECT_NEAR(r.tracker->state().T_WB.p.x(), 0.5, 1e-3);
  EXPECT_GT(r.tracker->cov()(3, 3), 1.0) << "nobody knows where it went meanwhile";
}

}  // namespace
}  // namespace pirvs
