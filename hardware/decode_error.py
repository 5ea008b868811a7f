"""What a codec says of bytes that it cannot accept."""


class DecodeError(ValueError):
    """These bytes are not what their format demands; whoever reads the line drops them and goes on."""
