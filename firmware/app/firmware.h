// The whole controller program without its threads: construct it over a board and call the four poll functions, from
// four threads on the robot (main.cpp) or one after the other in virtual time (in process). Not real-time as a whole:
// only tick() is.
#pragma once

#include "firmware/app/controller.h"
#include "firmware/board/board.h"
#include "firmware/config/settings.h"
#include "firmware/imu/imu_reader.h"
#include "firmware/imu/pose_reader.h"
#include "firmware/link/handover.h"
#include "firmware/link/link.h"
#include "shared/wire/secure_channel.h"

namespace sanso::firmware {

struct Board {
  board::SerialPort& bus;
  board::HidSource& imu;
  board::PoseSource* pose;  // may be null
  board::Datagram& link;
  board::Clock& clock;
};

class Firmware {
 public:
  Firmware(const Settings& settings, const wire::Key& key, const Board& board)
      : imu_(settings.imu, board.imu, handover_.imu),
        pose_(board.pose, handover_.pose),
        link_(key, board.link, handover_),
        controller_(settings, board.bus, board.clock, handover_) {}

  /// One tick, due at `now`: every 10 ms.
  void tick(Nanoseconds now) { controller_.tick(now); }
  /// Takes the IMU's reports; returns at `deadline` at the latest. In process: poll_imu(now, now) before every tick.
  void poll_imu(Nanoseconds now, Nanoseconds deadline) { imu_.poll(now, deadline); }
  void poll_pose(Nanoseconds now, Nanoseconds deadline) { pose_.poll(now, deadline); }
  /// Takes the host's datagrams and sends what the tick has published. In process: before and after every tick.
  void poll_link(Nanoseconds now, Nanoseconds deadline) { link_.poll(now, deadline); }

  const Controller& controller() const { return controller_; }
  Handover& handover() { return handover_; }
  const Link& link() const { return link_; }

 private:
  Handover handover_;
  ImuReader imu_;
  PoseReader pose_;
  Link link_;
  Controller controller_;
};

}  // namespace sanso::firmware
