"""The launcher behind `./bedload`: builds, runs, tests. It computes nothing of the flow."""
