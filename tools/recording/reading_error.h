// Why a file is no recording, for callers that sort their refusals by kind.
#pragma once

#include <string>
#include <utility>

#include "shared/files/input_error.h"

namespace sanso::recording {

enum class ReadFault { unreadable, too_large, not_a_number, missing_channel };

/// An input error whose kind a caller may ask for; `defect` stays the reader's own short name.
struct ReadingError : files::InputError {
  ReadingError(ReadFault fault_, std::string file_, int line_, std::string channel_,
               std::string defect_, std::string value_, std::string expected_)
      : InputError(std::move(file_), line_, std::move(channel_), std::move(defect_),
                   std::move(value_), std::move(expected_)),
        fault(fault_) {}

  ReadFault fault;
};

}  // namespace sanso::recording
