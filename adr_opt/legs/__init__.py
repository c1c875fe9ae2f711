"""How bodies are reached: connections and timetables."""
