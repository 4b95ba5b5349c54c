// The whole controller program without its threads: construct it on the heap (the tables of the
// layers take 7 MB) over a board and call the four poll functions, from four threads on the robot
// (main.cpp) or one after the other in virtual time (in process). Not real-time as a whole:
// only tick() is.
#pragma once

#include <memory>

#include "firmware/app/controller.h"
#include "firmware/board/board.h"
#include "firmware/config/settings.h"
#include "firmware/exchange/handover.h"
#include "firmware/imu/imu_reader.h"
#include "firmware/imu/mip_reader.h"
#include "firmware/imu/pose_reader.h"
#include "firmware/link/link.h"
#include "shared/wire/secure_channel.h"

namespace sanso::firmware {

struct Board {
  board::SerialPort& bus;
  board::HidSource& imu;
  board::PoseSource* pose;  // may be null
  board::Datagram& link;
  board::Clock& clock;
  board::SerialPort* mip = nullptr;  // a 3DM-GX5, which then stands for the IMU
};

class Firmware {
 public:
  Firmware(const Settings& settings, const wire::Key& key, const Board& board,
           const std::string& robot_name = {})
      : imu_(settings.imu, board.imu, board.clock, handover_.imu),
        mip_(board.mip != nullptr
                 ? std::make_unique<MipReader>(settings.imu, *board.mip, board.clock, handover_.imu)
                 : nullptr),
        pose_(board.pose, board.clock, handover_.pose),
        link_(key, board.link, board.clock, handover_, robot_name),
        controller_(settings, board.bus, board.clock, handover_) {}

  /// One tick, due at `now`: every 10 ms.
  void tick(Nanoseconds now) { controller_.tick(now); }
  /// Takes the IMU's reports; waits for the first until `deadline`. In process: poll_imu(0) before
  /// every tick.
  Status poll_imu(Nanoseconds deadline) {
    return mip_ ? mip_->poll(deadline) : imu_.poll(deadline);
  }
  Status poll_pose(Nanoseconds deadline) { return pose_.poll(deadline); }
  /// Takes the host's datagrams and sends what the tick has published. In process: before and after
  /// every tick.
  void poll_link(Nanoseconds deadline) { link_.poll(deadline); }

  const Controller& controller() const { return controller_; }
  Handover& handover() { return handover_; }
  const Link& link() const { return link_; }

 private:
  Handover handover_;
  ImuReader imu_;
  std::unique_ptr<MipReader> mip_;
  PoseReader pose_;
  Link link_;
  Controller controller_;
};

}  // namespace sanso::firmware
