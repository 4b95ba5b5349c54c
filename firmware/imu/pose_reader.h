// The pose thread's work: take the tracker's reports and hand the newest to the tick.
#pragma once

#include "firmware/board/board.h"
#include "firmware/exchange/mailbox.h"
#include "firmware/exchange/samples.h"

namespace sanso::firmware {

class PoseReader {
 public:
  PoseReader(board::PoseSource* source, board::Clock& clock, Mailbox<PoseSample>& out)
      : source_(source), clock_(clock), out_(out) {}
  /// Takes every report there is; waits for the first until `deadline`. Nothing happens without a
  /// source. Anything but ok: the source is gone and the call came back at once.
  Status poll(Nanoseconds deadline);
  bool present() const { return source_ != nullptr; }

 private:
  static constexpr int kMaxReportsAtOnce = 64;
  board::PoseSource* source_;
  board::Clock& clock_;
  Mailbox<PoseSample>& out_;
  std::uint32_t samples_ = 0;
};

}  // namespace sanso::firmware
