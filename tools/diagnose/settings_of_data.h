// What is asked of recordings before anything is explained: are they healthy, and what of them is
// compared.
#pragma once

namespace sanso::diagnose {

/// When the data gate takes a sample or a channel for what it is not.
struct GateSettings {
  int largest_file = 1024;
  int least_rows = 50;
  double least_seconds = 0.5;
  double gap_periods = 10.0;
  double gap_seconds = 0.1;
  double wrong_unit = 20.0;
  double answer_delay = 0.4;
  double answers = 0.7;
  double does_not_answer = 0.4;
  int flat_rows = 5;
  int flat_command_approach = 5;
  int flat_position_approach = 3;
  int flat_tops = 2;
  double glitch_deviations = 8.0;
  double glitch_quanta = 4.0;
  double glitch_steps = 3.0;
  double jump_steps = 10.0;
  double jump_dropout = 0.1;
  double jump_quanta = 20.0;
  int held_changes = 20;
  double resting_share = 0.1;
  double stale_step = 1.2;
  double stale_beyond = 3.0;
  double clipped_deviations = 3.0;
  double clock_skew = 0.1;
  double clock_between = 0.02;
  double clock_reach = 0.5;
  double clock_step = 0.005;
  int clock_pairs = 2000;
  double clock_unlike = 0.1;
  double columns_fit = 0.05;
  double columns_better = 4.0;
  int calm_rows = 40;
  int jump_rows = 5;
  template <class Field>
  void visit(Field&& field) {
    field("largest_file", largest_file, "MB", 1, 1000000,
          "10 s at 1 kHz with 60 channels are 10 MB: larger is a bag of images or an endless log");
    field("least_rows", least_rows, "rows", 20, 100000,
          "fewer cannot hold one shot and its hold-out");
    field("least_seconds", least_seconds, "s", 0.05, 100.0, "one shot of half a second");
    field("gap_periods", gap_periods, "sampling intervals", 2.0, 1000.0,
          "without a row: loss of packets of up to 30 % makes runs of eight");
    field("gap_seconds", gap_seconds, "s", 0.01, 10.0,
          "and long against what a servo does between two samples");
    field("wrong_unit", wrong_unit, "factor", 2.0, 1000.0,
          "between channels, or beyond the data sheet: no tolerance makes it");
    field("answer_delay", answer_delay, "s", 0.05, 5.0,
          "longest after which a servo's position is compared with its command");
    field("answers", answers, "correlation", 0.1, 2.0,
          "of a channel that follows another; from 1 on nothing is asked");
    field("does_not_answer", does_not_answer, "correlation", 0.05, 1.0,
          "below, a joint does not follow its own command or velocity");
    field("flat_rows", flat_rows, "rows", 2, 1000, "at exactly one value: a flat top");
    field("flat_command_approach", flat_command_approach, "rows", 1, 1000,
          "before and after a command's flat top in which it must move: no corner of a step");
    field("flat_position_approach", flat_position_approach, "rows", 1, 1000,
          "before and after a position's flat top that show how fast it came and went");
    field("flat_tops", flat_tops, "flat tops", 1, 1000, "of a channel that is cut off");
    field("glitch_deviations", glitch_deviations, "deviations", 1.0, 1000.0,
          "of how far samples usually leave the median of five: a glitch leaves it further");
    field("glitch_quanta", glitch_quanta, "small steps", 0.5, 1000.0,
          "of the channel, counts if it has any: readings flicker by one or two");
    field("glitch_steps", glitch_steps, "neighbouring steps", 0.5, 1000.0,
          "a reversal leaves that median by one at most, however hard the stop");
    field("jump_steps", jump_steps, "factor", 2.0, 1000.0,
          "beyond what the joint does in one row around it: a position that did not go there");
    field("jump_dropout", jump_dropout, "s", 0.001, 10.0,
          "at the recording's fastest: rows that were held and caught up move less far");
    field("jump_quanta", jump_quanta, "counts", 2.0, 100000.0,
          "of the encoder at least: less can be play or a count");
    field("held_changes", held_changes, "changes", 5, 100000,
          "of more than one count, to tell a held channel from one that moves slowly");
    field("resting_share", resting_share, "share", 0.001, 0.5,
          "of these at other distances: motion that rested; with more the channel is not held");
    field("stale_step", stale_step, "row changes", 0.5, 100.0,
          "caught up at once, in the median, behind rows written again: a rest ends slowly");
    field("stale_beyond", stale_beyond, "factor", 1.0, 1000.0,
          "beyond what coarse readings repeat together by chance");
    field("clipped_deviations", clipped_deviations, "deviations", 0.5, 100.0,
          "of the answer to other commands: further beyond a flat top, the command went on");
    field("clock_skew", clock_skew, "s", 0.01, 1.0,
          "further apart than any delay, filter or lead of the library puts two channels");
    field("clock_between", clock_between, "s", 0.001, 1.0,
          "and two rows: what a velocity's delay may differ by between recordings");
    field("clock_reach", clock_reach, "s", 0.02, 10.0, "to either side: longer is another motion");
    field("clock_step", clock_step, "s", 0.0005, 0.1, "between two shifts that are tried");
    field("clock_pairs", clock_pairs, "rows", 100, 1000000, "compared at one shift");
    field("clock_unlike", clock_unlike, "1 - correlation", 0.001, 0.5,
          "of a channel that follows the other at all");
    field("columns_fit", columns_fit, "share", 0.01, 0.9,
          "of torques that a model with its friction and gain free may leave: columns in order");
    field("columns_better", columns_better, "factor", 1.5, 100.0,
          "by which another reading of them leaves less before they are called wrong");
    field(
        "calm_rows", calm_rows, "rows", 12, 10000,
        "of a window in which noise is measured: long against its colour, short against a motion");
    field("jump_rows", jump_rows, "rows", 2, 1000,
          "that a speed or a place before and after a jump is taken over");
  }
};

/// What a smoother supposes of a motion before it has read any of it: deviations around the first
/// reading, at rest. Wide, so that readings alone decide.
struct SmootherSettings {
  double position = 1000.0;
  double speed = 100.0;
  double acceleration = 10000.0;
  template <class Field>
  void visit(Field&& field) {
    field("position", position, "deviations", 10.0, 1e6,
          "of the first reading: before it little is known");
    field("speed", speed, "rad/s (m/s)", 1.0, 1e6, "no joint of a robot is faster");
    field("acceleration", acceleration, "rad/s^2 (m/s^2)", 10.0, 1e8,
          "a stop within a row of a fast recording makes it");
  }
};

/// What is taken of the recordings, and how closely a simulation is asked to be right.
struct DataSettings {
  double shot_seconds = 0.5;
  int least_shot_rows = 10;
  double torque_window = 0.1;
  double fastest_rate = 1100.0;
  int maximum_rows = 40000;
  int maximum_shots = 120;
  double model_floor = 0.0002;
  double secondary_floor = 0.05;
  double arrival_inflation = 3.0;
  int compared_rows = 100;
  int smoothing_rounds = 3;
  int likelihood_rows = 6000;
  int coupled_starts = 4;
  double start_step_position = 0.0001;
  double start_step_velocity = 0.001;
  int instants = 5;
  int instant_steps = 8;
  double end_margin = 0.03;
  int velocity_samples = 2000;
  template <class Field>
  void visit(Field&& field) {
    field("shot_seconds", shot_seconds, "s", 0.05, 10.0,
          "length of a shot: the horizon an MPC feels; long enough for a servo's lag");
    field("least_shot_rows", least_shot_rows, "rows", 2, 1000,
          "slower recordings get longer shots: fewer rows show no shape of motion");
    field("torque_window", torque_window, "s", 0.01, 2.0,
          "window of the missing-torque residual; between 60 and 240 ms");
    field("fastest_rate", fastest_rate, "Hz", 50.0, 100000.0,
          "faster recordings are thinned; joint physics end far below");
    field("maximum_rows", maximum_rows, "rows x joints", 100, 10000000,
          "compared in a search; more only narrows intervals");
    field("maximum_shots", maximum_shots, "shots", 4, 100000,
          "compared in a search; the same reason");
    field("model_floor", model_floor, "share of the range", 0.0, 0.1,
          "of a position's range: below this no simulation is asked to be right");
    field("secondary_floor", secondary_floor, "share of the RMS", 0.0, 1.0,
          "of an electrical or velocity channel: gain error and filters of such sensors");
    field("arrival_inflation", arrival_inflation, "factor", 0.1, 100.0,
          "on the smoother's velocity deviation: its motion model is not the robot's");
    field("compared_rows", compared_rows, "rows", 10, 100000,
          "of a shot; 200 Hz at half a second: above it neighbouring errors are the same error");
    field("smoothing_rounds", smoothing_rounds, "rounds", 1, 100,
          "the speed that says how well a jittering reading is known settles in as many");
    field("likelihood_rows", likelihood_rows, "rows", 100, 10000000,
          "by which the smoother's density is chosen; more change it by less than a step");
    field("coupled_starts", coupled_starts, "joints", 1, 20,
          "with more, starts are moved all at once and coupling is left out of their derivative");
    field(
        "start_step_position", start_step_position, "rad (m)", 1e-07, 0.01,
        "of a start's derivative: well above the integrator's rounding, below any regime's width");
    field("start_step_velocity", start_step_velocity, "rad/s (m/s)", 1e-06, 0.1,
          "the same for the velocity");
    field("instants", instants, "instants", 1, 100,
          "at which what begins somewhere in a recording is probed: 0 and equal steps");
    field("instant_steps", instant_steps, "steps", 1, 1000,
          "of a shot, at which such an instant is looked for before it is halved to a row");
    field("end_margin", end_margin, "share of the range", 0.001, 0.25,
          "nearest to the end of a motion where a position is looked for: rows have to show it");
    field("velocity_samples", velocity_samples, "samples", 100, 1000000,
          "of a velocity channel by joint; more only sharpen a p that is small already");
  }
};

}  // namespace sanso::diagnose
