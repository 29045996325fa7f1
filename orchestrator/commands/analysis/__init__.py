"""Commands that find out: stability, coupling, friction, competition."""
