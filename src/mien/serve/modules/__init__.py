"""The four modules (SPEC C1): interpret, speak, translate, perform; and the streams that join them as programs."""
