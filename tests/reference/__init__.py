"""Independent reference models in plain Python and numpy: event-driven, friction is never time-stepped."""
