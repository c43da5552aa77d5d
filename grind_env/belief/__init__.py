"""Beliefs of the hidden wheel and lot, estimated from measurements."""
