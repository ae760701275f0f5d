#include "board/usb/uvc_control.h"

#include <errno.h>
#include <gtest/gtest.h>

#include <cstring>

namespace pirvs::board {
namespace {

constexpr uint8_t kIn = 0xa1, kOut = 0x21;  // class, to an interface
constexpr uint8_t kControl = 4, kStreaming = 5;

UvcControl control() {
  UvcControl out;
  UvcFormat format;
  format.width = 640;
  format.height = 480;
  format.control_interface = kControl;
  format.streaming_interface = kStreaming;
  out.configure(format);
  return out;
}

uvc_request_data ask(uint8_t type, uint8_t request, uint8_t selector, uint16_t index,
                     uint16_t length) {
  usb_ctrlrequest setup{};
  setup.bRequestType = type;
  setup.bRequest = request;
  setup.wValue = uint16_t(selector << 8);
  setup.wIndex = index;
  setup.wLength = length;
  return control().answer(setup);
}

TEST(UvcControl, OffersItsOneFormatWhateverIsAsked) {
  for (const uint8_t selector : {UVC_VS_PROBE_CONTROL, UVC_VS_COMMIT_CONTROL}) {
    for (const uint8_t request : {UVC_GET_CUR, UVC_GET_MIN, UVC_GET_MAX, UVC_GET_DEF}) {
      const uvc_request_data got = ask(kIn, request, selector, kStreaming, 34);
      ASSERT_EQ(got.length, 34);
      uvc_streaming_control offer;
      std::memcpy(&offer, got.data, sizeof offer);
      EXPECT_EQ(offer.bFormatIndex, 1);
      EXPECT_EQ(offer.bFrameIndex, 1);
      EXPECT_EQ(offer.dwFrameInterval, 166'666u);
      EXPECT_EQ(offer.dwMaxVideoFrameSize, 640u * 480);
      EXPECT_EQ(offer.dwMaxPayloadTransferSize, 3072u);
    }
  }
}

TEST(UvcControl, GivesNoMoreThanIsAsked) {
  EXPECT_EQ(ask(kIn, UVC_GET_CUR, UVC_VS_PROBE_CONTROL, kStreaming, 26).length, 26);
  EXPECT_EQ(ask(kIn, UVC_GET_CUR, UVC_VS_PROBE_CONTROL, kStreaming, 64).length, 34);
}

TEST(UvcControl, TakesWhatIsSet) {
  EXPECT_EQ(ask(kOut, UVC_SET_CUR, UVC_VS_PROBE_CONTROL, kStreaming, 34).length, 34);
  EXPECT_EQ(ask(kOut, UVC_SET_CUR, UVC_VS_COMMIT_CONTROL, kStreaming, 26).length, 26);
}

TEST(UvcControl, SaysItsLengthAndWhatItCan) {
  const uvc_request_data length = ask(kIn, UVC_GET_LEN, UVC_VS_PROBE_CONTROL, kStreaming, 2);
  ASSERT_EQ(length.length, 2);
  EXPECT_EQ(length.data[0], 34);
  EXPECT_EQ(length.data[1], 0);
  const uvc_request_data info = ask(kIn, UVC_GET_INFO, UVC_VS_PROBE_CONTROL, kStreaming, 1);
  ASSERT_EQ(info.length, 1);
  EXPECT_EQ(info.data[0], 3);
}

// The selectors of both interfaces are the same numbers.
TEST(UvcControl, RefusesWhatItDoesNotHaveAndSaysWhy) {
  EXPECT_EQ(ask(kIn, UVC_GET_CUR, UVC_VS_PROBE_CONTROL, kControl, 34).length, -EL2HLT);
  EXPECT_EQ(ask(kIn, UVC_GET_CUR, 3, kStreaming, 34).length, -EL2HLT);
  EXPECT_EQ(ask(kIn, UVC_GET_RES, UVC_VS_PROBE_CONTROL, kStreaming, 34).length, -EL2HLT);
  EXPECT_EQ(ask(kIn, UVC_GET_CUR, UVC_VS_PROBE_CONTROL, 0x0200 | kControl, 2).length, -EL2HLT);
  EXPECT_EQ(ask(kIn, UVC_GET_CUR, UVC_VS_PROBE_CONTROL, 9, 34).length, -EL2HLT);
  EXPECT_EQ(ask(0xc0, UVC_GET_CUR, UVC_VS_PROBE_CONTROL, kStreaming, 34).length, -EL2HLT);
  const uvc_request_data why =
      ask(kIn, UVC_GET_CUR, UVC_VC_REQUEST_ERROR_CODE_CONTROL, kControl, 1);
  ASSERT_EQ(why.length, 1);
  EXPECT_EQ(why.data[0], 6) << "invalid control";
}

}  // namespace
}  // namespace pirvs::board
