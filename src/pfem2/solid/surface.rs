//! The surface of solids in a configuration: nearest points, signed distance, places inside (theory J.2).
