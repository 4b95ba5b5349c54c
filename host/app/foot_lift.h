// How far the feet rose in a trial, as the robot itself believes.
#pragma once

#include "host/learn/episodes/episode.h"

namespace sanso::app {

/// Share of the reference's lift of feet that the estimate shows, 0 to 1: sum of
/// min(h, h_ref) h_ref over that of h_ref^2, over both feet and the ticks in which one of them is
/// lifted by 5 mm. h, h_ref: height of a sole's lowest corner above the other sole's [m]. Attitude
/// and joints decide it, so neither the height of the floor nor anything that only an emulated
/// world knows. Negative where the reference lifts no foot.
double lifted_share(const learn::Episode& episode);

}  // namespace sanso::app
